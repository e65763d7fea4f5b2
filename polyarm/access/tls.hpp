#pragma once
/// The TLS certificate that identifies this machine to others: read from files, or generated.
#include <filesystem>
#include <string>

namespace polyarm::server {

struct Certificate {
  std::string chain, key;   ///< PEM
  std::string fingerprint;  ///< SHA-256 of the first certificate: "3A:F1:…"
};

/// Reads a certificate and its key. Throws Error("no-certificate") if a file cannot be read or is not PEM, or
/// if the two do not belong together.
Certificate read_certificate(const std::filesystem::path& chain, const std::filesystem::path& key);

/// The certificate of this user, stored in `folder` and readable only by this user. A new one (ECDSA P-256,
/// self-signed) is made if there is none, if another user could have read the key, or if it expires within a
/// month. Throws Error("no-certificate").
Certificate kept_certificate(const std::filesystem::path& folder, const std::string& host_name);

}  // namespace polyarm::server
