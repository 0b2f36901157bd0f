#include "environment/output/field_output.h"

#include <gtest/gtest.h>

#include <cmath>

namespace espalier::environment::field_output_test {
namespace {

using turtle::Field;

/// 3 by 2 by 2 cells with the values 0 … 11.
Field small() {
  Field field{"a<b", "mol/m^3", {3, 2, 2}, {-1.5, 0.1, 2}, {0.5, 1, 0.25}, {}};
  for (int i = 0; i < 12; ++i) {
    field.values.push_back(i);
  }
  return field;
}

TEST(FieldOutput, AVtiFileReadsBackExactly) {
  Field second = small();
  second.name = "tenths";
  for (double& value : second.values) {
    value = 0.1 * value - 1e-300;
  }
  const std::vector<Field> fields{small(), second};
  const std::string text = writeVti(fields);
  EXPECT_NE(text.find("WholeExtent=\"0 3 0 2 0 2\" Origin=\"-1.5 0.1 2\" Spacing=\"0.5 1 0.25\""), std::string::npos);
  const auto read = readVti(text);
  ASSERT_TRUE(read.has_value()) << read.error();
  EXPECT_EQ(read.value(), fields);
}

TEST(FieldOutput, AVtiFileOfOthersIsRead) {
  // as VTK writes it in ascii, with an extent that does not begin at 0
  const auto read = readVti(
      "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\">\n<ImageData WholeExtent=\"2 4 0 1 0 1\" Origin=\"0 0 "
      "0\" "
      "Spacing=\"2 1 1\"><Piece Extent=\"2 4 0 1 0 1\"><PointData></PointData><CellData>"
      "<DataArray type=\"Float32\" Name=\"c\" format=\"ascii\">\n 1 2.5 \n</DataArray></CellData></Piece></ImageData>"
      "</VTKFile>");
  ASSERT_TRUE(read.has_value()) << read.error();
  const Field expected{"c", "1", {2, 1, 1}, {4, 0, 0}, {2, 1, 1}, {1, 2.5}};
  EXPECT_EQ(read.value(), std::vector<Field>{expected});
}

TEST(FieldOutput, WhatCannotBeReadIsSaid) {
  const auto problem = [](const std::string& text) {
    const auto read = readVti(text);
    return read ? std::string() : read.error();
  };
  const std::string good = writeVti(std::vector<Field>{small()});
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_EQ(problem("<html></html>"),
            "is no VTK image data file (.vti) with cell data. `python3 -m espalier.fields FILE out.vti` makes one of "
            "netCDF and Zarr");
  EXPECT_EQ(problem(changed("version=\"1.0\" byte", "compressor=\"vtkLZ4DataCompressor\" byte")),
            "is compressed by 'vtkLZ4DataCompressor': write it with SetDataModeToAppended or SetDataModeToBinary, and "
            "SetCompressorTypeToZLib or SetCompressorTypeToNone");
  EXPECT_EQ(problem(changed("LittleEndian", "BigEndian")), "is big-endian: write it with SetByteOrderToLittleEndian");
  EXPECT_EQ(problem(changed("0 3 0 2 0 2", "0 3 0 2")),
            "has no extent of six numbers, or an origin or spacing without three");
  EXPECT_EQ(problem(changed("0 3 0 2 0 2", "0 3 0 2 0 0")), "has an extent without cells, or with too many");
  EXPECT_EQ(problem(changed("0 3 0 2 0 2", "0 3 0 2 0 4")), "has 12 numbers in 'a<b' for 24 cells");
  EXPECT_EQ(problem(changed("Float64", "Float99")), "has a data array of the unknown type 'Float99'");
  EXPECT_EQ(problem(changed("format=\"binary\"", "format=\"appended\" offset=\"0\"")),
            "has a data array that is damaged or cut short. Get a complete copy");
  EXPECT_EQ(problem(changed("format=\"binary\"", "format=\"text\"")),
            "has data of the format 'text': write it with SetDataModeToAppended or SetDataModeToBinary, and "
            "SetCompressorTypeToZLib or SetCompressorTypeToNone");
  EXPECT_EQ(problem(changed("\"binary\">\n", "\"binary\">\n*")),
            "has a data array that is no base64, or is cut short. Get a complete copy");
}

TEST(FieldOutput, RawNumbersReadBackWithTheirHeader) {
  const Field field = small();
  const auto read = readRaw(writeRawHeader(field), writeRaw(field));
  ASSERT_TRUE(read.has_value()) << read.error();
  EXPECT_EQ(read.value(), field);
  EXPECT_EQ(readRaw(writeRawHeader(field), "abc").error(), "has 3 bytes instead of 8 for each of its cells");
  EXPECT_EQ(readRaw("{", "").error(), "has a header that is no JSON");
  EXPECT_EQ(readRaw("{}", "").error(), "has a header without three 'cells', a 'position' and a 'cellSize'");
  std::string header = writeRawHeader(field);
  header.replace(header.find("float64"), 7, "float32");
  EXPECT_EQ(readRaw(header, "").error(), "is not of the type float64, little-endian");
  // words that are no text count as absent
  header = writeRawHeader(field);
  header.replace(header.find("\"float64\""), 9, "7");
  EXPECT_EQ(readRaw(header, writeRaw(field)).value().values, field.values);
}

TEST(FieldOutput, SlicesAndMeansLieAsOneLooksAtThem) {
  const Field field = small();
  // along z: x to the right, y upwards; the slice at z = 2.1 holds the values 0 … 5
  const auto slice = viewField(field, {2, 2.1}).value();
  EXPECT_EQ(slice.width, 3U);
  EXPECT_EQ(slice.values, (std::vector<double>{3, 4, 5, 0, 1, 2}));
  EXPECT_EQ(viewField(field, {2, std::nullopt}).value().values, (std::vector<double>{6, 7, 8, 3, 4, 5}));
  // along x: z to the right, y upwards; along y: x to the right, the smallest z at the top
  EXPECT_EQ(viewField(field, {0, -1.4}).value().values, (std::vector<double>{3, 9, 0, 6}));
  EXPECT_EQ(viewField(field, {1, 0.2}).value().values, (std::vector<double>{0, 1, 2, 6, 7, 8}));
  EXPECT_EQ(viewField(field, {1, 5}).error(), "'a<b' reaches from 0.1 to 2.1 along y: choose a slice there");
}

TEST(FieldOutput, ColoursGoFromDarkBlueToYellow) {
  const auto pixels = colourPlane({3, 1, {2, 3, 4}}, 2, 4);
  EXPECT_EQ(pixels, (std::vector<std::uint8_t>{68, 1, 84, 255, 35, 144, 140, 255, 253, 231, 37, 255}));
  EXPECT_EQ(colourPlane({1, 1, {7}}, 7, 7).size(), 4U);
}

TEST(FieldOutput, TheRangeIsThatOfTheNumbersThatAreFinite) {
  EXPECT_EQ(rangeOf({3, 1, {2, HUGE_VAL, -1}}), std::pair(-1.0, 2.0));
  EXPECT_EQ(rangeOf({1, 1, {std::nan("")}}), std::pair(0.0, 0.0));
  EXPECT_EQ(colourPlane({2, 1, {std::nan(""), HUGE_VAL}}, 0, 1),
            (std::vector<std::uint8_t>{190, 190, 190, 255, 253, 231, 37, 255}));
}

TEST(FieldOutput, ASummaryHasTheIntegralOverTheBox) {
  const FieldSummary summary = summaryOf(small());
  EXPECT_EQ(summary.minimum, 0);
  EXPECT_EQ(summary.maximum, 11);
  EXPECT_EQ(summary.mean, 5.5);
  EXPECT_EQ(summary.integral, 66 * 0.125);
}

TEST(FieldOutput, ASummaryLeavesOutCellsWithoutANumber) {
  Field field = small();
  field.values[0] = std::nan("");
  const FieldSummary summary = summaryOf(field);
  EXPECT_EQ(summary.count, 11);
  EXPECT_EQ(summary.minimum, 1);
  EXPECT_EQ(summary.mean, 6);
  field.values.assign(field.values.size(), std::nan(""));
  EXPECT_TRUE(std::isnan(summaryOf(field).mean));
}

}  // namespace
}  // namespace espalier::environment::field_output_test
