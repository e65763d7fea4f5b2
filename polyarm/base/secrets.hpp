#pragma once
/// Passwords and private keys: they never go into a recording, a record of a fault, or a project's zip.
#include <filesystem>
#include <string>
#include <string_view>

namespace polyarm {

/// In front of the name of a secret, where a cell's file may name a file: `password_file: secret:broker`.
inline constexpr std::string_view kSecretPrefix = "secret:";

/// The file of a secret by its name, `config_folder()/secrets/NAME`. Throws Error("bad-secret") for a name
/// that is a path, a file that is not there, and one that others may read.
std::filesystem::path secret_file(const std::string& name);

/// From now on the file is known to hold a secret: something loads it as one. Any thread.
void mark_secret(const std::filesystem::path& file);
/// Was it marked, or does its name or content say that it is a secret: NAME.key, .password, .token …, a PEM
/// file with a private key?
bool is_secret(const std::filesystem::path& file);
bool is_secret(const std::filesystem::path& file, std::string_view content);

/// The text without the values of keys such as `password:`, `token:` and `<param name="api_key">`.
std::string without_secrets(std::string_view text);

}  // namespace polyarm
