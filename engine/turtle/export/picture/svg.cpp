#include "engine/turtle/export/picture/svg.h"

#include <algorithm>
#include <set>
#include <string>

#include "engine/core/elementary.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/page_drawing.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

namespace {

void writeHex(const Colour& colour, TextOutput& out) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  out << '#';
  for (const unsigned char channel : {colour.red, colour.green, colour.blue}) {
    out << kDigits[channel >> 4U] << kDigits[channel & 15U];
  }
}

std::string gradientName(const Colour& colour) {
  std::string hex;
  TextOutput out(hex);
  writeHex(colour, out);
  out.flush();
  return "s" + hex.substr(1);
}

void writeEscaped(std::string_view text, TextOutput& out) {
  for (const char c : text) {
    switch (c) {
      case '<':
        out << "&lt;";
        break;
      case '>':
        out << "&gt;";
        break;
      case '&':
        out << "&amp;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 32) {
          out << c;
        }
    }
  }
}

class SvgWriter {
 public:
  SvgWriter(const Scene& scene, const PageDrawing& page, TextOutput& out) : scene_(scene), page_(page), out_(out) {}

  void writeHead(const Colour* background);
  void writeLines(const PageLines& lines);
  void writeShape(const PageShape& shape);

 private:
  void writePoint(const PagePlace& p) {
    out_.number(p.x, 2) << ' ';
    out_.number(p.y, 2);
  }
  void writeStrokes(const PageLines& lines);
  void writeOutlines(const PageLines& lines);
  void writeOpacity(double opacity);

  const Scene& scene_;
  const PageDrawing& page_;
  TextOutput& out_;
};

void SvgWriter::writeHead(const Colour* background) {
  out_ << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" "
          "width=\"";
  out_.number(page_.width(), 2) << "\" height=\"";
  out_.number(page_.height(), 2) << "\" viewBox=\"0 0 ";
  out_.number(page_.width(), 2) << ' ';
  out_.number(page_.height(), 2) << "\">\n";
  std::set<std::string> written;
  for (const PageShape& shape : page_.shapes()) {
    if (shape.kind != PageShape::Kind::Sphere || !written.insert(gradientName(shape.colour)).second) {
      continue;
    }
    out_ << "<radialGradient id=\"" << gradientName(shape.colour)
         << "\" cx=\"0.38\" cy=\"0.32\" r=\"0.75\"><stop offset=\"0\" "
         << "stop-color=\"";
    writeHex(mixed(shape.colour, {255, 252, 240}, 0.45), out_);
    out_ << "\"/><stop offset=\"0.55\" stop-color=\"";
    writeHex(shape.colour, out_);
    out_ << "\"/><stop offset=\"1\" stop-color=\"";
    writeHex(mixed(shape.colour, {22, 26, 30}, 0.42), out_);
    out_ << "\"/></radialGradient>\n";
  }
  if (background != nullptr) {
    out_ << "<rect width=\"100%\" height=\"100%\" fill=\"";
    writeHex(*background, out_);
    out_ << "\"/>\n";
  }
}

void SvgWriter::writeOpacity(double opacity) {
  if (opacity < 1.0) {
    out_ << " opacity=\"";
    out_.number(opacity, 3) << '"';
  }
}

void SvgWriter::writeLines(const PageLines& lines) {
  out_ << "<path class=\"order-" << std::to_string(lines.order) << '"';
  writeOpacity(lines.opacity);
  lines.width > 0.0 ? writeStrokes(lines) : writeOutlines(lines);
}

// lines of one width: strokes that go on as long as the turtle did
void SvgWriter::writeStrokes(const PageLines& lines) {
  out_ << " fill=\"none\" stroke=\"";
  writeHex(lines.colour, out_);
  out_ << "\" stroke-width=\"";
  out_.number(lines.width, 2) << "\" stroke-linecap=\"round\" stroke-linejoin=\"round\" d=\"";
  const Segment* before = nullptr;
  for (const std::uint32_t index : lines.segments) {
    const Segment& segment = scene_.segments[index];
    if (before == nullptr || before->end != segment.start) {
      out_ << 'M';
      writePoint(page_.place(segment.start));
    }
    out_ << 'L';
    writePoint(page_.place(segment.end));
    before = &segment;
  }
  out_ << "\"/>\n";
}

// lines that taper: the outline of each, with round ends
void SvgWriter::writeOutlines(const PageLines& lines) {
  out_ << " fill=\"";
  writeHex(lines.colour, out_);
  out_ << "\" d=\"";
  for (const std::uint32_t index : lines.segments) {
    const Segment& segment = scene_.segments[index];
    const PagePlace a = page_.place(segment.start);
    const PagePlace b = page_.place(segment.end);
    const double r0 = page_.radius(segment, false);
    const double r1 = page_.radius(segment, true);
    const double l = core::hypot(b.x - a.x, b.y - a.y);
    // seen from its end a line is a dot
    const double nx = l > 1e-6 ? (b.y - a.y) / l : 1.0;
    const double ny = l > 1e-6 ? -(b.x - a.x) / l : 0.0;
    const auto arc = [this](double r) {
      out_ << 'A';
      out_.number(r, 2) << ' ';
      out_.number(r, 2) << " 0 0 1 ";
    };
    out_ << 'M';
    writePoint({a.x + nx * r0, a.y + ny * r0});
    out_ << 'L';
    writePoint({b.x + nx * r1, b.y + ny * r1});
    arc(r1);
    writePoint({b.x - nx * r1, b.y - ny * r1});
    out_ << 'L';
    writePoint({a.x - nx * r0, a.y - ny * r0});
    arc(r0);
    writePoint({a.x + nx * r0, a.y + ny * r0});
    out_ << 'Z';
  }
  out_ << "\"/>\n";
}

void SvgWriter::writeShape(const PageShape& shape) {
  const PagePlace at = page_.point(shape, 0);
  switch (shape.kind) {
    case PageShape::Kind::Face:
      out_ << "<path";
      writeOpacity(shape.opacity);
      out_ << " d=\"";
      for (std::uint32_t k = 0; k < shape.pointCount; ++k) {
        out_ << (k == 0 ? 'M' : 'L');
        writePoint(page_.point(shape, k));
      }
      // a hairline of the same colour closes the seams between neighbours
      out_ << "Z\" fill=\"";
      writeHex(shape.colour, out_);
      out_ << "\" stroke=\"";
      writeHex(shape.colour, out_);
      out_ << "\" stroke-width=\"0.4\"/>\n";
      return;
    case PageShape::Kind::Sphere:
    case PageShape::Kind::Disc:
      out_ << "<circle";
      writeOpacity(shape.opacity);
      out_ << " cx=\"";
      out_.number(at.x, 2) << "\" cy=\"";
      out_.number(at.y, 2) << "\" r=\"";
      out_.number(shape.radius, 2) << "\" fill=\"";
      if (shape.kind == PageShape::Kind::Sphere) {
        out_ << "url(#" << gradientName(shape.colour) << ")";
      } else {
        writeHex(shape.colour, out_);
      }
      out_ << "\"/>\n";
      return;
    case PageShape::Kind::Text:
      out_ << "<text x=\"";
      out_.number(at.x, 2) << "\" y=\"";
      out_.number(at.y, 2) << "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"";
      writeHex(shape.colour, out_);
      out_ << "\">";
      writeEscaped(scene_.labels[shape.label].text, out_);
      out_ << "</text>\n";
      return;
  }
}

}  // namespace

void writeSvg(const Scene& scene, const files::ViewSettings& view, const SvgOptions& options, core::ByteSink& sink) {
  const Palette palette(scene, view, options.palette);
  const PageDrawing page(scene, view, palette, options.widthPixels, options.heightPixels, options.marginFraction,
                         options.frame);
  TextOutput out(sink);
  SvgWriter writer(scene, page, out);
  const Colour background = palette.background();
  writer.writeHead(options.hasBackground ? &background : nullptr);
  for (const PageLines& lines : page.lines()) {
    writer.writeLines(lines);
  }
  for (const PageShape& shape : page.shapes()) {
    writer.writeShape(shape);
  }
  out << "</svg>\n";
  out.flush();
}

}  // namespace espalier::turtle
