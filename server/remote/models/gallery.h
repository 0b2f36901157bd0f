#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace espalier::server {

/// The file that makes a folder a forest (clients/espalier/README.md).
inline constexpr const char* kForestFile = "forest.json";

/// The gallery that came with this program: beside an installed one (share/espalier/gallery), or in the source tree in
/// which it was built; empty when there is none.
[[nodiscard]] std::string galleryOfProgram();

/// The conformance suite that came with this program, found in the same way.
[[nodiscard]] std::string conformanceOfProgram();

/// The handbook as a site that came with this program (share/doc/espalier/handbook), or that ./dev docs built.
[[nodiscard]] std::string handbookOfProgram();

/// Names of the model folders in the gallery folder, sorted.
[[nodiscard]] std::vector<std::string> galleryNames(const std::string& gallery);

/// Every model of the gallery: NAME for a folder with one model, NAME/FILE or NAME/FILE:ENTRY for the models of other
/// folders. Reads the files; sorted.
[[nodiscard]] std::vector<std::string> galleryEntries(const std::string& gallery);

/// The folder of a gallery model; nothing unless `name` is one of galleryNames, so that no name leads out of the
/// gallery.
[[nodiscard]] std::optional<std::filesystem::path> galleryFolderOf(const std::string& gallery, const std::string& name);

/// A message with the names of files within the gallery: clients do not learn where the server keeps it.
[[nodiscard]] std::string withinGallery(const std::string& gallery, std::string text);

/// The path of a model as a person names it: a file or folder by that name, else the folder of the model with that name
/// in galleryOfProgram(), else the name itself.
[[nodiscard]] std::string pathOrGallery(const std::string& name);

/// The files of a model of the gallery.
struct GalleryModel {
  std::string main;                          // FILE or FILE:ENTRY
  std::map<std::string, std::string> files;  // bytes by name in the folder
};

/// Reads the model `entry` of galleryEntries. `used` are the files that its compiler read. A folder with one model also
/// gives the other files that a person edits: panels, functions, environments, its README. No path leads out of the
/// folder.
[[nodiscard]] GalleryModel readGalleryModel(const std::string& gallery, const std::string& entry,
                                            const std::vector<std::string>& used);

/// The path on the HTTP side, `/gallery/NAME/FILE.png`, of the picture of each entry that has one.
[[nodiscard]] std::map<std::string, std::string> galleryPictures(const std::string& gallery,
                                                                 const std::vector<std::string>& entries);

/// The bytes of the picture FILE.png in the folder NAME; nothing when there is none.
[[nodiscard]] std::optional<std::string> readGalleryPicture(const std::string& gallery, const std::string& name,
                                                            const std::string& file);

/// The file of a stem with the suffix in a folder, else the only one with the suffix; empty when there is none or a
/// choice.
[[nodiscard]] std::string fileWithSuffix(const std::filesystem::path& folder, const std::string& stem,
                                         const std::string& suffix);

/// The text of an environment's configuration as the text of a list: a single process in brackets.
[[nodiscard]] std::string asEnvironmentList(const std::string& configuration);

}  // namespace espalier::server
