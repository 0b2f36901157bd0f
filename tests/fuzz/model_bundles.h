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

/// A text of the repository with its name.
struct NamedText {
  std::string name;
  std::string text;
};

/// The content of a file as it is.
[[nodiscard]] std::string contentOf(const std::filesystem::path& file);

/// The models in the folders of `below`, without files of more than 50,000 bytes, in the order of their names.
[[nodiscard]] std::vector<ModelBundle> modelBundles(const std::filesystem::path& below);

/// The model files of other programs (engine/language/dialects) in the folders of `below`, in the order of their names.
[[nodiscard]] std::vector<NamedText> foreignModels(const std::filesystem::path& below);

/// The forest files in the folders of `below`, each with the files of its folder in one text (bundle.h).
[[nodiscard]] std::vector<NamedText> forestBundles(const std::filesystem::path& below);

}  // namespace espalier::fuzz
