#include "environment/base/image_of_line.h"

#include "environment/base/published_text.h"

namespace espalier::environment {

tl::expected<files::Image, std::string> readImageBeside(const PublishedLineInput& input, std::string_view name) {
  const std::string path = besideFile(input.file, std::string(name));
  const auto content = input.files.read(path);
  if (!content) {
    return tl::unexpected("names the file '" + path +
                          "', which cannot be read; it is looked for beside the specification");
  }
  auto image = files::readImageFile(path, *content, files::Opacity::OverBlack);
  if (!image) {
    return tl::unexpected("names the file '" + path + "', which cannot be used: " + image.error());
  }
  return image;
}

}  // namespace espalier::environment
