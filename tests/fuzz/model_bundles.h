#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace espalier::fuzz {

/// One of the repository's models with the files of its folder, in one text (bundle.h).
struct ModelBundle {
  std::string name;  // of the folder
  std::string text;  // empty: the folder has no model
  std::string view;  // the same files with the view file first; empty: there is none
};

/// The content of a file as it is.
[[nodiscard]] std::string contentOf(const std::filesystem::path& file);

/// The models in the folders of `below`, without files of more than 50,000 bytes, in the order of their names.
[[nodiscard]] std::vector<ModelBundle> modelBundles(const std::filesystem::path& below);

}  // namespace espalier::fuzz
