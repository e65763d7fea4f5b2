#pragma once
/// The certificate by which other machines know this one.
#include <filesystem>
#include <string>

namespace polyarm::server {

struct Certificate {
  std::string chain, key;   ///< PEM
  std::string fingerprint;  ///< SHA-256 of the first certificate: "3A:F1:…"
};

/// A certificate with its key from files. Throws Error("no-certificate") where they cannot be read, are no PEM or
/// do not belong together.
Certificate read_certificate(const std::filesystem::path& chain, const std::filesystem::path& key);

/// The certificate of this user, which `folder` keeps readable for this user alone; made anew (ECDSA P-256, signed
/// by itself) where there is none, somebody else could have read its key, or it ends within a month. Throws
/// Error("no-certificate").
Certificate kept_certificate(const std::filesystem::path& folder, const std::string& host_name);

}  // namespace polyarm::server
