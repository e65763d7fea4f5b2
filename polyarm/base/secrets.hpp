#pragma once
/// Passwords and private keys. They are never written to a recording, a fault record or a project's zip.
#include <filesystem>
#include <string>
#include <string_view>

namespace polyarm {

/// In front of the name of a secret, where a cell's file may name a file: `password_file: secret:broker`.
inline constexpr std::string_view kSecretPrefix = "secret:";

/// Returns the file of a secret, `config_folder()/secrets/NAME`. Throws Error("bad-secret") if the name is a
/// path, the file does not exist, or others may read it.
std::filesystem::path secret_file(const std::string& name);

/// Marks the file as secret. Call it when a file is loaded as a secret. Any thread.
void mark_secret(const std::filesystem::path& file);
/// True if the file is marked, or if its name or content shows a secret: NAME.key, .password, .token …, a
/// PEM file with a private key.
bool is_secret(const std::filesystem::path& file);
bool is_secret(const std::filesystem::path& file, std::string_view content);

/// The text without the values of keys such as `password:`, `token:` and `<param name="api_key">`.
std::string without_secrets(std::string_view text);

}  // namespace polyarm
