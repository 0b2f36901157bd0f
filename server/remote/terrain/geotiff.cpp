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
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "engine/core/optional_library.h"
#include "engine/files/length_unit.h"
#include "server/remote/terrain/height_band.h"
#include "server/remote/terrain/memory_file.h"
#include "server/remote/terrain/tiff_tags.h"

namespace espalier::server {

#ifdef ESPALIER_HAS_GEOTIFF

namespace {

constexpr const char* kLibrary = "libgeotiff.so.5";
constexpr std::uint64_t kMostTileBytes = std::uint64_t{64} << 20;
constexpr tmsize_t kMostBytes = tmsize_t{256} << 20;  // that libtiff takes at once
constexpr std::uint32_t kMetadataTag = 42112;         // of GDAL
constexpr std::uint32_t kNoDataTag = 42113;           // of GDAL
constexpr int kMostImages = 100;                      // of one file: heights, overviews, masks
constexpr const char* kAsMetres =
    ". Convert it to a projection in metres: gdalwarp -t_srs EPSG:NUMBER -dstnodata -9999";
constexpr const char* kDamaged = "is damaged or cut short: its heights cannot be decoded. Get a complete copy";

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
  decltype(&::TIFFComputeStrip) stripOf = nullptr;
  decltype(&::TIFFComputeTile) tileOf = nullptr;
  decltype(&::TIFFGetStrileByteCount) writtenBytes = nullptr;
  decltype(&::TIFFLastDirectory) isLastImage = nullptr;
  decltype(&::TIFFReadDirectory) nextImage = nullptr;
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
  library.find(functions.stripOf, "TIFFComputeStrip");
  library.find(functions.tileOf, "TIFFComputeTile");
  library.find(functions.writtenBytes, "TIFFGetStrileByteCount");
  library.find(functions.isLastImage, "TIFFLastDirectory");
  library.find(functions.nextImage, "TIFFReadDirectory");
  library.find(functions.makeKeys, "GTIFNewEx");
  library.find(functions.freeKeys, "GTIFFree");
  library.find(functions.keyOf, "GTIFKeyGetSHORT");
  if (!library.isComplete()) {
    return std::nullopt;
  }
  functions.initialize();
  return functions;
}

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
    file_ = call_.open("terrain", "rm", &memory_, MemoryFile::read, MemoryFile::write, MemoryFile::seek,
                       MemoryFile::close, MemoryFile::size, nullptr, nullptr, options);
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
    for (const auto& step : {&GeoTiff::readKind, &GeoTiff::readKeys, &GeoTiff::readPlace, &GeoTiff::readMetadata,
                             &GeoTiff::readHeights, &GeoTiff::readMasks}) {
      if (auto problem = (this->*step)()) {
        return tl::unexpected(std::move(*problem));
      }
    }
    if (auto problem = band_.finish(terrain_.heights)) {
      return tl::unexpected(std::move(*problem));
    }
    return std::move(terrain_);
  }

 private:
  using Problem = std::optional<std::string>;

  Problem readKind() {
    std::uint32_t columns = 0;
    std::uint32_t rows = 0;
    std::uint16_t bands = 1;
    std::uint16_t bits = 1;
    std::uint16_t format = SAMPLEFORMAT_UINT;
    call_.get(file_, TIFFTAG_IMAGEWIDTH, &columns);
    call_.get(file_, TIFFTAG_IMAGELENGTH, &rows);
    call_.getOrDefault(file_, TIFFTAG_SAMPLESPERPIXEL, &bands);
    call_.getOrDefault(file_, TIFFTAG_BITSPERSAMPLE, &bits);
    call_.getOrDefault(file_, TIFFTAG_SAMPLEFORMAT, &format);
    if (columns < 2 || rows < 2) {
      return "has " + std::to_string(columns) + " x " + std::to_string(rows) +
             " heights. A ground needs at least 2 x 2";
    }
    if (std::uint64_t{columns} * rows > kMostHeights) {
      return "has " + std::to_string(columns) + " x " + std::to_string(rows) + " heights, more than " +
             std::to_string(kMostHeights) +
             ". Make it coarser, as with gdal_translate -outsize 50% 50%, or cut out a part";
    }
    if (bands != 1) {
      return "has " + std::to_string(bands) +
             " bands. Give a file with one band of heights, as with gdal_translate -b 1";
    }
    const bool isReal = format == SAMPLEFORMAT_IEEEFP && (bits == 32 || bits == 64);
    const bool isWhole =
        (format == SAMPLEFORMAT_INT || format == SAMPLEFORMAT_UINT) && (bits == 8 || bits == 16 || bits == 32);
    if (!isReal && !isWhole) {
      return std::string(
          "has numbers of a kind that is not read. Write whole numbers of 8, 16 or 32 bits or real ones "
          "of 32 or 64, as with gdal_translate -ot Float32");
    }
    band_.bits = bits;
    band_.isReal = isReal;
    band_.isSigned = format == SAMPLEFORMAT_INT;
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
    if (across && *across != files::kMetre) {
      return files::notInMetres(*across) + kAsMetres;
    }
    if (upward && *upward != files::kMetre) {
      return files::notInMetres(*upward) + kAsMetres + ", then gdal_edit.py -units m";
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
        return std::string("is turned. Turn its rows to the north: gdalwarp -dstnodata -9999");
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
                         "has cells that do not go from the north to the south and from the west to the east. Turn it: "
                         "gdalwarp -dstnodata -9999");
  }

  /// The text of a tag of GDAL; empty: there is none.
  std::string_view textOf(std::uint32_t tag) {
    std::uint32_t count = 0;
    const char* text = nullptr;
    return call_.get(file_, tag, &count, &text) == 1 && text != nullptr ? std::string_view(text, ::strnlen(text, count))
                                                                        : std::string_view();
  }

  Problem readMetadata() {
    band_.takeNoData(textOf(kNoDataTag));
    return band_.takeMetadata(textOf(kMetadataTag));
  }

  Problem readHeights() { return readNumbers(band_, terrain_.heights); }

  /// Reads the numbers of the current image, which has the size of the terrain. Those of a strip or tile that was
  /// never written are NaN.
  Problem readNumbers(const HeightBand& band, std::vector<double>& numbers) {
    numbers.assign(terrain_.rows * terrain_.columns, std::numeric_limits<double>::quiet_NaN());
    return call_.isTiled(file_) == 0 ? readLines(band, numbers) : readTiles(band, numbers);
  }

  Problem readLines(const HeightBand& band, std::vector<double>& numbers) {
    if (call_.lineBytes(file_) != band.bytesOf(terrain_.columns)) {
      return kDamaged;
    }
    std::vector<char> line(band.bytesOf(terrain_.columns));
    for (std::size_t row = 0; row < terrain_.rows; ++row) {
      const auto y = static_cast<std::uint32_t>(row);
      if (call_.writtenBytes(file_, call_.stripOf(file_, y, 0)) == 0) {
        continue;
      }
      if (call_.readLine(file_, line.data(), y, 0) != 1) {
        return kDamaged;
      }
      for (std::size_t column = 0; column < terrain_.columns; ++column) {
        numbers[row * terrain_.columns + column] = band.numberAt(line.data(), column);
      }
    }
    return std::nullopt;
  }

  Problem readTiles(const HeightBand& band, std::vector<double>& numbers) {
    std::uint32_t across = 0;
    std::uint32_t down = 0;
    call_.get(file_, TIFFTAG_TILEWIDTH, &across);
    call_.get(file_, TIFFTAG_TILELENGTH, &down);
    const std::uint64_t bytes = call_.tileBytes(file_);
    const std::size_t rowBytes = band.bytesOf(across);
    if (across == 0 || down == 0 || bytes != std::uint64_t{down} * rowBytes) {
      return kDamaged;
    }
    if (bytes > kMostTileBytes) {
      return "has tiles that are too large (" + std::to_string(across) + " x " + std::to_string(down) +
             "): write it again with gdal_translate";
    }
    std::vector<char> tile(bytes);
    for (std::size_t row = 0; row < terrain_.rows; row += down) {
      for (std::size_t column = 0; column < terrain_.columns; column += across) {
        const auto left = static_cast<std::uint32_t>(column);
        const auto top = static_cast<std::uint32_t>(row);
        if (call_.writtenBytes(file_, call_.tileOf(file_, left, top, 0, 0)) == 0) {
          continue;
        }
        if (call_.readTile(file_, tile.data(), left, top, 0, 0) < 0) {
          return kDamaged;
        }
        for (std::size_t y = row; y < std::min<std::size_t>(row + down, terrain_.rows); ++y) {
          for (std::size_t x = column; x < std::min<std::size_t>(column + across, terrain_.columns); ++x) {
            numbers[y * terrain_.columns + x] = band.numberAt(tile.data() + (y - row) * rowBytes, x - column);
          }
        }
      }
    }
    return std::nullopt;
  }

  /// Looks for cells that a mask in the file leaves out. Masks of overviews do not count.
  Problem readMasks() {
    for (int image = 1; call_.isLastImage(file_) == 0; ++image) {
      if (image == kMostImages) {
        return "has more than " + std::to_string(kMostImages) + " images: write it again with gdal_translate";
      }
      if (call_.nextImage(file_) != 1) {
        return kDamaged;
      }
      std::uint32_t kind = 0;
      call_.getOrDefault(file_, TIFFTAG_SUBFILETYPE, &kind);
      if ((kind & FILETYPE_MASK) == 0 || (kind & FILETYPE_REDUCEDIMAGE) != 0) {
        continue;
      }
      std::uint32_t columns = 0;
      std::uint32_t rows = 0;
      HeightBand mask;
      std::uint16_t bands = 1;
      call_.get(file_, TIFFTAG_IMAGEWIDTH, &columns);
      call_.get(file_, TIFFTAG_IMAGELENGTH, &rows);
      call_.getOrDefault(file_, TIFFTAG_SAMPLESPERPIXEL, &bands);
      call_.getOrDefault(file_, TIFFTAG_BITSPERSAMPLE, &mask.bits);
      if (columns != terrain_.columns || rows != terrain_.rows || bands != 1 || (mask.bits != 1 && mask.bits != 8)) {
        return std::string("has a mask of a kind that is not read. Write it without one: gdalwarp -dstnodata -9999");
      }
      std::vector<double> isValid;
      if (auto problem = readNumbers(mask, isValid)) {
        return problem;
      }
      // gdal_fillnodata.py alone loses the mask and fills nothing
      if (const auto missing = std::ranges::count_if(isValid, [](double bit) { return !(bit > 0.0); }); missing > 0) {
        return "has " + std::to_string(missing) + " of " + std::to_string(isValid.size()) +
               " cells without a height: its mask leaves them out. Write a number in place of the mask with gdalwarp "
               "-dstnodata -9999, and fill them, as with gdal_fillnodata.py";
      }
    }
    return std::nullopt;
  }

  const Functions& call_;
  MemoryFile memory_;
  TIFF* file_ = nullptr;
  HeightBand band_;
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
  if (!hasWholeGeoTags(bytes)) {
    return tl::unexpected(
        std::string("is damaged or cut short: what it says of its place and unit is not there. Get a complete copy"));
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
