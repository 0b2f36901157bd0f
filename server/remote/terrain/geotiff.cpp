#include "server/remote/terrain/geotiff.h"

#if __has_include(<geotiff/geotiff.h>) && __has_include(<tiffio.h>)
#define ESPALIER_HAS_GEOTIFF 1
#include <geotiff/geokeys.h>
#include <geotiff/geotiff.h>
#include <geotiff/geovalues.h>
#include <geotiff/xtiffio.h>
#include <tiffio.h>
#endif

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "engine/core/optional_library.h"
#include "engine/files/length_unit.h"

namespace espalier::server {

#ifdef ESPALIER_HAS_GEOTIFF

namespace {

constexpr const char* kLibrary = "libgeotiff.so.5";
constexpr std::uint64_t kMostTileBytes = std::uint64_t{64} << 20;
constexpr tmsize_t kMostBytes = tmsize_t{256} << 20;  // that libtiff takes at once
constexpr std::uint32_t kMetadataTag = 42112;         // of GDAL
constexpr std::uint32_t kNoDataTag = 42113;           // of GDAL
constexpr const char* kAsMetres = ". Convert it to a projection in metres, as with gdalwarp";

/// The functions of libgeotiff and libtiff that are used.
struct Functions {
  decltype(&::XTIFFInitialize) initialize = nullptr;
  decltype(&::TIFFOpenOptionsAlloc) makeOptions = nullptr;
  decltype(&::TIFFOpenOptionsFree) freeOptions = nullptr;
  decltype(&::TIFFOpenOptionsSetMaxSingleMemAlloc) setMostBytes = nullptr;
  decltype(&::TIFFOpenOptionsSetErrorHandlerExtR) setErrorHandler = nullptr;
  decltype(&::TIFFOpenOptionsSetWarningHandlerExtR) setWarningHandler = nullptr;
  decltype(&::TIFFClientOpenExt) open = nullptr;
  decltype(&::TIFFClose) close = nullptr;
  decltype(&::TIFFGetField) get = nullptr;
  decltype(&::TIFFGetFieldDefaulted) getOrDefault = nullptr;
  decltype(&::TIFFIsTiled) isTiled = nullptr;
  decltype(&::TIFFScanlineSize64) lineBytes = nullptr;
  decltype(&::TIFFReadScanline) readLine = nullptr;
  decltype(&::TIFFTileSize64) tileBytes = nullptr;
  decltype(&::TIFFReadTile) readTile = nullptr;
  decltype(&::GTIFNewEx) makeKeys = nullptr;
  decltype(&::GTIFFree) freeKeys = nullptr;
  decltype(&::GTIFKeyGetSHORT) keyOf = nullptr;
};

/// Loads the libraries; nothing when they are not installed. They stay loaded.
std::optional<Functions> load() {
  core::OptionalLibrary library(kLibrary);
  Functions functions;
  library.find(functions.initialize, "XTIFFInitialize");
  library.find(functions.makeOptions, "TIFFOpenOptionsAlloc");
  library.find(functions.freeOptions, "TIFFOpenOptionsFree");
  library.find(functions.setMostBytes, "TIFFOpenOptionsSetMaxSingleMemAlloc");
  library.find(functions.setErrorHandler, "TIFFOpenOptionsSetErrorHandlerExtR");
  library.find(functions.setWarningHandler, "TIFFOpenOptionsSetWarningHandlerExtR");
  library.find(functions.open, "TIFFClientOpenExt");
  library.find(functions.close, "TIFFClose");
  library.find(functions.get, "TIFFGetField");
  library.find(functions.getOrDefault, "TIFFGetFieldDefaulted");
  library.find(functions.isTiled, "TIFFIsTiled");
  library.find(functions.lineBytes, "TIFFScanlineSize64");
  library.find(functions.readLine, "TIFFReadScanline");
  library.find(functions.tileBytes, "TIFFTileSize64");
  library.find(functions.readTile, "TIFFReadTile");
  library.find(functions.makeKeys, "GTIFNewEx");
  library.find(functions.freeKeys, "GTIFFree");
  library.find(functions.keyOf, "GTIFKeyGetSHORT");
  if (!library.isComplete()) {
    return std::nullopt;
  }
  functions.initialize();
  return functions;
}

/// A file in memory as libtiff reads it.
struct Memory {
  std::string_view bytes;
  std::uint64_t at = 0;

  static tmsize_t read(thandle_t self, void* target, tmsize_t count) {
    auto* const memory = static_cast<Memory*>(self);
    const std::uint64_t left = memory->at < memory->bytes.size() ? memory->bytes.size() - memory->at : 0;
    const auto taken = static_cast<std::size_t>(
        std::min<std::uint64_t>(left, static_cast<std::uint64_t>(std::max<tmsize_t>(count, 0))));
    if (taken > 0) {
      std::memcpy(target, memory->bytes.data() + memory->at, taken);
    }
    memory->at += taken;
    return static_cast<tmsize_t>(taken);
  }
  static tmsize_t write(thandle_t, void*, tmsize_t) { return 0; }
  static toff_t seek(thandle_t self, toff_t offset, int from) {
    auto* const memory = static_cast<Memory*>(self);
    memory->at = offset + (from == SEEK_CUR ? memory->at : from == SEEK_END ? memory->bytes.size() : 0);
    return memory->at;
  }
  static int close(thandle_t) { return 0; }
  static toff_t size(thandle_t self) { return static_cast<Memory*>(self)->bytes.size(); }
};

/// Messages of the libraries are dropped: the caller gets one sentence.
int dropMessage(TIFF*, void*, const char*, const char*, va_list) {
  return 1;
}
void dropKeyMessage(GTIF*, int, const char*, ...) {}

/// One open file.
class GeoTiff {
 public:
  GeoTiff(const Functions& functions, std::string_view bytes) : call_(functions), memory_{bytes} {
    TIFFOpenOptions* const options = call_.makeOptions();
    call_.setMostBytes(options, kMostBytes);
    call_.setErrorHandler(options, dropMessage, nullptr);
    call_.setWarningHandler(options, dropMessage, nullptr);
    file_ = call_.open("terrain", "rm", &memory_, Memory::read, Memory::write, Memory::seek, Memory::close,
                       Memory::size, nullptr, nullptr, options);
    call_.freeOptions(options);
  }
  ~GeoTiff() {
    if (file_ != nullptr) {
      call_.close(file_);
    }
  }
  GeoTiff(const GeoTiff&) = delete;
  GeoTiff& operator=(const GeoTiff&) = delete;

  tl::expected<Terrain, std::string> read() {
    if (file_ == nullptr) {
      return tl::unexpected(std::string("is no TIFF file, or is damaged. Give a GeoTIFF of heights"));
    }
    for (const auto& step :
         {&GeoTiff::readKind, &GeoTiff::readKeys, &GeoTiff::readPlace, &GeoTiff::readHeights, &GeoTiff::checkHeights}) {
      if (auto problem = (this->*step)()) {
        return tl::unexpected(std::move(*problem));
      }
    }
    return std::move(terrain_);
  }

 private:
  using Problem = std::optional<std::string>;

  Problem readKind() {
    std::uint32_t columns = 0;
    std::uint32_t rows = 0;
    std::uint16_t bands = 1;
    call_.get(file_, TIFFTAG_IMAGEWIDTH, &columns);
    call_.get(file_, TIFFTAG_IMAGELENGTH, &rows);
    call_.getOrDefault(file_, TIFFTAG_SAMPLESPERPIXEL, &bands);
    call_.getOrDefault(file_, TIFFTAG_BITSPERSAMPLE, &bits_);
    call_.getOrDefault(file_, TIFFTAG_SAMPLEFORMAT, &sampleFormat_);
    if (columns < 2 || rows < 2) {
      return "has " + std::to_string(columns) + " x " + std::to_string(rows) +
             " heights. A ground needs at least 2 x 2";
    }
    if (std::uint64_t{columns} * rows > kMostHeights) {
      return "has " + std::to_string(columns) + " x " + std::to_string(rows) + " heights, more than " +
             std::to_string(kMostHeights) + ". Make it coarser, as with gdal_translate -outsize, or cut out a part";
    }
    if (bands != 1) {
      return "has " + std::to_string(bands) +
             " bands. Give a file with one band of heights, as with gdal_translate -b 1";
    }
    const bool isReal = sampleFormat_ == SAMPLEFORMAT_IEEEFP && (bits_ == 32 || bits_ == 64);
    const bool isWhole = (sampleFormat_ == SAMPLEFORMAT_INT || sampleFormat_ == SAMPLEFORMAT_UINT) &&
                         (bits_ == 8 || bits_ == 16 || bits_ == 32);
    if (!isReal && !isWhole) {
      return std::string(
          "has numbers of a kind that is not read. Write whole numbers of 8, 16 or 32 bits or real ones "
          "of 32 or 64, as with gdal_translate -ot Float32");
    }
    terrain_.columns = columns;
    terrain_.rows = rows;
    return std::nullopt;
  }

  Problem readKeys() {
    GTIF* const keys = call_.makeKeys(file_, dropKeyMessage, nullptr);
    if (keys == nullptr) {
      return std::string("has no usable geographic keys. Give a GeoTIFF");
    }
    const auto keyOf = [&](geokey_t key) {
      unsigned short value = 0;
      return call_.keyOf(keys, key, &value, 0, 1) == 1 ? std::optional(value) : std::nullopt;
    };
    const auto model = keyOf(GTModelTypeGeoKey);
    const auto raster = keyOf(GTRasterTypeGeoKey);
    // a system known by its number alone: its unit stands in a database
    const auto unitOf = [&](geokey_t unitKey, geokey_t systemKey) -> std::optional<unsigned> {
      if (const auto unit = keyOf(unitKey)) {
        return *unit;
      }
      const auto system = keyOf(systemKey);
      return system && *system != KvUserDefined ? files::unitOfSystem(*system) : std::nullopt;
    };
    const auto across = unitOf(ProjLinearUnitsGeoKey, ProjectedCSTypeGeoKey);
    const auto upward = unitOf(VerticalUnitsGeoKey, VerticalCSTypeGeoKey);
    call_.freeKeys(keys);
    isPoint_ = raster == RasterPixelIsPoint;
    if (model == ModelTypeGeographic) {
      return std::string("has coordinates in degrees") + kAsMetres;
    }
    for (const auto& unit : {across, upward}) {
      if (unit && *unit != files::kMetre) {
        return files::notInMetres(*unit) + kAsMetres;
      }
    }
    terrain_.lengthUnit = across ? "m" : "";
    return std::nullopt;
  }

  Problem readPlace() {
    std::uint16_t count = 0;
    double* numbers = nullptr;
    const double half = isPoint_ ? 0.0 : 0.5;
    if (call_.get(file_, TIFFTAG_GEOPIXELSCALE, &count, &numbers) == 1 && count >= 2) {
      terrain_.eastStep = numbers[0];
      terrain_.southStep = numbers[1];
      if (call_.get(file_, TIFFTAG_GEOTIEPOINTS, &count, &numbers) != 1 || count < 6) {
        return std::string("does not say where it lies. Give a GeoTIFF with a tie point");
      }
      terrain_.west = numbers[3] + (half - numbers[0]) * terrain_.eastStep;
      terrain_.north = numbers[4] - (half - numbers[1]) * terrain_.southStep;
    } else if (call_.get(file_, TIFFTAG_GEOTRANSMATRIX, &count, &numbers) == 1 && count >= 8) {
      if (numbers[1] != 0.0 || numbers[4] != 0.0) {
        return std::string("is turned. Turn its rows to the north, as with gdalwarp");
      }
      terrain_.eastStep = numbers[0];
      terrain_.southStep = -numbers[5];
      terrain_.west = numbers[3] + half * terrain_.eastStep;
      terrain_.north = numbers[7] - half * terrain_.southStep;
    } else {
      return std::string("does not say where it lies: it has no pixel scale and no matrix. Give a GeoTIFF");
    }
    const bool isRight =
        terrain_.eastStep > 0.0 && terrain_.southStep > 0.0 &&
        std::max({terrain_.eastStep, terrain_.southStep, std::abs(terrain_.west), std::abs(terrain_.north)}) < 1e100;
    return isRight ? std::nullopt
                   : Problem(
                         "has cells that do not go from the north to the south and from the west to the east. Turn it, "
                         "as with gdalwarp");
  }

  /// The number at a place of decoded bytes.
  [[nodiscard]] double numberAt(const char* at) const {
    const auto as = [at](auto value) {
      std::memcpy(&value, at, sizeof(value));
      return static_cast<double>(value);
    };
    if (sampleFormat_ == SAMPLEFORMAT_IEEEFP) {
      return bits_ == 64 ? as(double{}) : as(float{});
    }
    if (sampleFormat_ == SAMPLEFORMAT_INT) {
      return bits_ == 8 ? as(std::int8_t{}) : bits_ == 16 ? as(std::int16_t{}) : as(std::int32_t{});
    }
    return bits_ == 8 ? as(std::uint8_t{}) : bits_ == 16 ? as(std::uint16_t{}) : as(std::uint32_t{});
  }

  Problem readHeights() {
    const std::string damaged = "is damaged or cut short: its heights cannot be decoded. Get a complete copy";
    const std::size_t width = bits_ / 8;
    terrain_.heights.resize(terrain_.rows * terrain_.columns);
    if (call_.isTiled(file_) == 0) {
      if (call_.lineBytes(file_) != terrain_.columns * width) {
        return damaged;
      }
      std::vector<char> line(terrain_.columns * width);
      for (std::size_t row = 0; row < terrain_.rows; ++row) {
        if (call_.readLine(file_, line.data(), static_cast<std::uint32_t>(row), 0) != 1) {
          return damaged;
        }
        for (std::size_t column = 0; column < terrain_.columns; ++column) {
          terrain_.heights[row * terrain_.columns + column] = numberAt(line.data() + column * width);
        }
      }
      return std::nullopt;
    }
    std::uint32_t across = 0;
    std::uint32_t down = 0;
    call_.get(file_, TIFFTAG_TILEWIDTH, &across);
    call_.get(file_, TIFFTAG_TILELENGTH, &down);
    const std::uint64_t bytes = call_.tileBytes(file_);
    if (across == 0 || down == 0 || bytes > kMostTileBytes || bytes != std::uint64_t{across} * down * width) {
      return damaged;
    }
    std::vector<char> tile(bytes);
    for (std::size_t row = 0; row < terrain_.rows; row += down) {
      for (std::size_t column = 0; column < terrain_.columns; column += across) {
        if (call_.readTile(file_, tile.data(), static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row), 0,
                           0) < 0) {
          return damaged;
        }
        for (std::size_t y = row; y < std::min<std::size_t>(row + down, terrain_.rows); ++y) {
          for (std::size_t x = column; x < std::min<std::size_t>(column + across, terrain_.columns); ++x) {
            terrain_.heights[y * terrain_.columns + x] =
                numberAt(tile.data() + ((y - row) * across + (x - column)) * width);
          }
        }
      }
    }
    return std::nullopt;
  }

  /// The number that stands for no height.
  std::optional<double> noData() {
    std::uint32_t count = 0;
    const char* text = nullptr;
    double value = 0.0;
    if (call_.get(file_, kNoDataTag, &count, &text) != 1 || text == nullptr) {
      return std::nullopt;
    }
    const std::string_view field(text, ::strnlen(text, count));
    const auto [rest, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    return error == std::errc() ? std::optional(value) : std::nullopt;
  }

  /// The number of an item of GDAL's metadata, as `<Item name="SCALE" sample="0" role="scale">0.01</Item>`.
  [[nodiscard]] std::optional<double> itemOf(const std::string& role) {
    std::uint32_t count = 0;
    const char* text = nullptr;
    if (call_.get(file_, kMetadataTag, &count, &text) != 1 || text == nullptr) {
      return std::nullopt;
    }
    const std::string_view items(text, ::strnlen(text, count));
    const std::size_t at = items.find("role=\"" + role + "\"");
    const std::size_t begin = at == std::string_view::npos ? at : items.find('>', at);
    double value = 0.0;
    if (begin == std::string_view::npos ||
        std::from_chars(items.data() + begin + 1, items.data() + items.size(), value).ec != std::errc()) {
      return std::nullopt;
    }
    return value;
  }

  Problem checkHeights() {
    const std::optional<double> none = noData();
    const auto isMissing = [&](double height) { return !(std::abs(height) < 1e100) || (none && height == *none); };
    const auto missing = std::ranges::count_if(terrain_.heights, isMissing);
    if (missing > 0) {
      return "has " + std::to_string(missing) + " of " + std::to_string(terrain_.heights.size()) +
             " cells without a height. Fill them, as with gdal_fillnodata.py, or cut out a part";
    }
    const double scale = itemOf("scale").value_or(1.0);
    const double offset = itemOf("offset").value_or(0.0);
    for (double& height : terrain_.heights) {
      height = height * scale + offset;
    }
    if (std::ranges::any_of(terrain_.heights, [](double height) { return !(std::abs(height) < 1e100); })) {
      return std::string("has a scale or an offset that is no finite number. Get an undamaged copy");
    }
    return std::nullopt;
  }

  const Functions& call_;
  Memory memory_;
  TIFF* file_ = nullptr;
  std::uint16_t bits_ = 0;
  std::uint16_t sampleFormat_ = SAMPLEFORMAT_UINT;
  bool isPoint_ = false;  // a number is that of a point, not of an area
  Terrain terrain_;
};

}  // namespace

tl::expected<Terrain, std::string> readGeoTiff(std::string_view bytes) {
  static const std::optional<Functions> functions = load();
  if (!functions) {
    return tl::unexpected(
        std::string("needs the library libgeotiff, which is not installed. Install libgeotiff5 (Debian)"));
  }
  return GeoTiff(*functions, bytes).read();
}

#else

tl::expected<Terrain, std::string> readGeoTiff(std::string_view) {
  return tl::unexpected(
      std::string("cannot be read: this program was built without libgeotiff. Install libgeotiff-dev "
                  "(Debian) and build again"));
}

#endif

}  // namespace espalier::server
