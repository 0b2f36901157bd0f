#include "environment/output/vtk_arrays.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>

#include "environment/output/field_output.h"

namespace espalier::environment::vtk_arrays_test {
namespace {

std::string word(std::uint64_t number, std::size_t size) {
  std::string bytes;
  for (std::size_t i = 0; i < size; ++i) {
    bytes.push_back(static_cast<char>((number >> (8 * i)) & 0xFFU));
  }
  return bytes;
}

std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = (group << 8U) | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text.push_back(i + k <= bytes.size() ? kDigits[(group >> (18U - 6U * k)) & 63U] : '=');
    }
  }
  return text;
}

/// How a test file is written, as the classes of VTK do it.
struct Form {
  std::size_t size = 4;  // of a number of the header
  bool isCompressed = true;
  bool isAppended = true;
  bool isBase64 = true;
  std::size_t block = 32;  // bytes
};

/// An array as VTK packs it: the header, and base64 of it apart from that of compressed blocks.
std::string packed(const std::string& bytes, const Form& form) {
  const auto coded = [&](const std::string& part) { return form.isBase64 ? base64(part) : part; };
  if (!form.isCompressed) {
    return coded(word(bytes.size(), form.size) + bytes);
  }
  std::string blocks;
  std::string sizes;
  std::size_t count = 0;
  for (std::size_t at = 0; at < bytes.size(); at += form.block, ++count) {
    const std::string block = bytes.substr(at, form.block);
    uLongf size = compressBound(block.size());
    std::string small(size, '\0');
    EXPECT_EQ(compress(reinterpret_cast<Bytef*>(small.data()), &size, reinterpret_cast<const Bytef*>(block.data()),
                       block.size()),
              Z_OK);
    blocks += small.substr(0, size);
    sizes += word(size, form.size);
  }
  return coded(word(count, form.size) + word(form.block, form.size) + word(bytes.size() % form.block, form.size) +
               sizes) +
         coded(blocks);
}

/// Two quantities in 3 by 2 by 2 cells: 0 … 11 in doubles, and halves of them in floats.
std::string fileOf(const Form& form) {
  std::string doubles;
  std::string floats;
  for (int i = 0; i < 12; ++i) {
    doubles += word(std::bit_cast<std::uint64_t>(static_cast<double>(i)), 8);
    floats += word(std::bit_cast<std::uint32_t>(0.5F * static_cast<float>(i)), 4);
  }
  const std::string first = packed(doubles, form);
  const std::string second = packed(floats, form);
  const auto array = [&](const std::string& type, const std::string& name, std::size_t offset,
                         const std::string& data) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"" +
           (form.isAppended ? "appended\" RangeMin=\"0\" offset=\"" + std::to_string(offset) + "\"/>\n"
                            : "binary\">\n" + data + "\n</DataArray>\n");
  };
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
         "header_type=\"" +
         std::string(form.size == 8 ? "UInt64" : "UInt32") + "\"" +
         (form.isCompressed ? " compressor=\"vtkZLibDataCompressor\"" : "") +
         ">\n<ImageData WholeExtent=\"0 3 0 2 0 2\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\n<Piece Extent=\"0 3 0 2 0 "
         "2\">\n<PointData>\n</PointData>\n<CellData Scalars=\"a\">\n" +
         array("Float64", "a", 0, first) + array("Float32", "b", first.size(), second) +
         "</CellData>\n</Piece>\n</ImageData>\n" +
         (form.isAppended ? "<AppendedData encoding=\"" + std::string(form.isBase64 ? "base64" : "raw") + "\">\n_" +
                                first + second + "\n</AppendedData>\n"
                          : "") +
         "</VTKFile>\n";
}

TEST(VtkArrays, FilesOfEveryDataModeOfVtkAreRead) {
  for (const Form& form : {Form{}, Form{.size = 8}, Form{.isBase64 = false}, Form{.size = 8, .isBase64 = false},
                           Form{.isCompressed = false}, Form{.isCompressed = false, .isBase64 = false},
                           Form{.isAppended = false}, Form{.size = 8, .isAppended = false},
                           Form{.isCompressed = false, .isAppended = false}, Form{.block = 96}, Form{.block = 1000}}) {
    const auto fields = readVti(fileOf(form));
    ASSERT_TRUE(fields.has_value()) << fields.error() << form.size << form.isCompressed << form.isAppended
                                    << form.isBase64 << form.block;
    ASSERT_EQ(fields->size(), 2U);
    for (int i = 0; i < 12; ++i) {
      EXPECT_EQ(fields->at(0).values[static_cast<std::size_t>(i)], i);
      EXPECT_EQ(fields->at(1).values[static_cast<std::size_t>(i)], 0.5 * i);
    }
  }
}

TEST(VtkArrays, AnArrayThatBeginsAsOneOfTheVtkLibraryIsRead) {
  // the corners of a square: one block of 48 bytes, packed into 17. The first 35 characters are from a file of the
  // library's writer; zlib at its usual level gives the same, and the rest
  const auto bytes =
      unpackedBytes("\n  AQAAAACAAAAwAAAAEQAAAA==eJxjYEAGDfaobEw+ADwjA7w=\n", true, {.isCompressed = true}, 48);
  ASSERT_TRUE(bytes.has_value()) << bytes.error();
  std::string expected;
  for (const float number : {0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 1.0F, 1.0F, 0.0F, 0.0F, 1.0F, 1.0F}) {
    expected += word(std::bit_cast<std::uint32_t>(number), 4);
  }
  EXPECT_EQ(*bytes, expected);
}

TEST(VtkArrays, DamagedArraysAreRefused) {
  const std::string damaged = "has a data array that is damaged or cut short. Get a complete copy";
  const std::string tooLong = "has a data array that is too long for its cells. Get an undamaged copy";
  const Form form{.isBase64 = false};
  const std::string good = fileOf(form);
  const std::size_t start = good.find("\n_") + 2;
  const auto problem = [&](std::size_t index, std::uint64_t number) {
    std::string text = good;
    text.replace(start + 4 * index, 4, word(number, 4));
    const auto fields = readVti(text);
    return fields ? std::string() : fields.error();
  };
  EXPECT_EQ(problem(0, 3), "");                // the number of blocks as it is
  EXPECT_EQ(problem(0, 0xFFFFFFFF), damaged);  // of blocks
  EXPECT_EQ(problem(0, 40), tooLong);          // 40 blocks of 32 bytes for 12 numbers
  EXPECT_EQ(problem(1, 0xFFFFFFFF), tooLong);  // bytes of a block
  EXPECT_EQ(problem(2, 0xFFFFFFFF), tooLong);  // bytes of the last one
  EXPECT_EQ(problem(1, 31), damaged);          // blocks have more
  EXPECT_EQ(problem(3, 0xFFFFFFFF), damaged);  // packed bytes of the first
  EXPECT_EQ(problem(3, 5), damaged);
  EXPECT_EQ(problem(6, 0x12345678), damaged);  // the first block
  for (const bool isBase64 : {false, true}) {
    for (const bool isCompressed : {false, true}) {
      const std::string whole = fileOf({.isCompressed = isCompressed, .isBase64 = isBase64});
      const auto fields = readVti(whole.substr(0, whole.find("\n_") + 60));
      EXPECT_EQ(fields ? std::string() : fields.error(), damaged);
    }
  }
  std::string far = good;
  far.replace(far.find("offset=\"0\""), 10, "offset=\"1e300\"");
  EXPECT_EQ(readVti(far).error(), damaged);
  std::string longer = fileOf({.isCompressed = false, .isBase64 = false});
  longer.replace(longer.find("\n_") + 2, 4, word(97, 4));
  EXPECT_EQ(readVti(longer).error(), tooLong);
}

TEST(VtkArrays, AFileMayNotUnpackMoreThanItsBound) {
  // an array of 2²⁸ cells is read; a second one is too many
  std::string text = fileOf({});
  text.replace(text.find("0 3 0 2 0 2"), 11, "0 268435456 0 1 0 1");
  EXPECT_EQ(readVti(text).error(), "has 12 numbers in 'a' for 268435456 cells");
  text.replace(text.find("0 268435456 0 1 0 1"), 19, "0 268435457 0 1 0 1");
  EXPECT_EQ(readVti(text).error(),
            "has more than 268435456 numbers in packed arrays. Write fewer quantities into a file");
}

}  // namespace
}  // namespace espalier::environment::vtk_arrays_test
