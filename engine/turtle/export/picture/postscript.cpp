#include "engine/turtle/export/picture/postscript.h"

#include <cmath>
#include <string>

#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/page_drawing.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

namespace {

// abbreviations, so that large drawings stay small: x y m, x y l, x0 y0 r0 x1 y1 r1 t (a line that tapers)
constexpr std::string_view kProlog = R"(%%BeginProlog
/m {moveto} bind def
/l {lineto} bind def
/s {stroke} bind def
/f {closepath fill} bind def
/c {setrgbcolor} bind def
/d {0 360 arc fill} bind def
/t {
  /r1 exch def /y1 exch def /x1 exch def /r0 exch def /y0 exch def /x0 exch def
  /a x1 x0 sub dup mul y1 y0 sub dup mul add 0 gt {y1 y0 sub x1 x0 sub atan} {0} ifelse def
  newpath x0 y0 r0 a 90 add a 270 add arc x1 y1 r1 a 90 sub a 90 add arc closepath fill
} bind def
%%EndProlog
)";
constexpr double kFontSize = 10.0;

class PostScriptWriter {
 public:
  PostScriptWriter(const Scene& scene, const PageDrawing& page, TextOutput& out)
      : scene_(scene), page_(page), out_(out) {}

  void writeHead(int lineCap);
  void writeLines(const PageLines& lines);
  void writeShape(const PageShape& shape);

 private:
  // PostScript's y goes up
  TextOutput& point(const PagePlace& p) {
    out_.number(p.x, 2) << ' ';
    return out_.number(page_.height() - p.y, 2) << ' ';
  }
  void writeColour(const Colour& colour);
  void writeText(const std::string& text);

  const Scene& scene_;
  const PageDrawing& page_;
  TextOutput& out_;
  std::string colour_;  // in use
};

void PostScriptWriter::writeHead(int lineCap) {
  out_ << "%!PS-Adobe-3.0 EPSF-3.0\n%%Creator: Espalier\n%%BoundingBox: 0 0 ";
  out_.integer(static_cast<long long>(std::ceil(page_.width()))) << ' ';
  out_.integer(static_cast<long long>(std::ceil(page_.height()))) << "\n%%HiResBoundingBox: 0 0 ";
  out_.number(page_.width(), 2) << ' ';
  out_.number(page_.height(), 2) << "\n%%LanguageLevel: 2\n%%Pages: 1\n%%EndComments\n"
                                 << kProlog << "%%Page: 1 1\ngsave\n";
  out_.integer(lineCap) << " setlinecap 1 setlinejoin\n/Helvetica findfont ";
  out_.number(kFontSize, 2) << " scalefont setfont\n";
}

void PostScriptWriter::writeColour(const Colour& colour) {
  std::string channels;
  TextOutput text(channels);
  for (const unsigned char channel : {colour.red, colour.green, colour.blue}) {
    text.number(channel / 255.0, 3) << ' ';
  }
  text.flush();
  if (channels != colour_) {
    colour_ = std::move(channels);
    out_ << colour_ << "c\n";
  }
}

void PostScriptWriter::writeLines(const PageLines& lines) {
  out_ << "% order " << std::to_string(lines.order) << '\n';
  writeColour(lines.colour);
  if (lines.width > 0.0) {
    out_.number(lines.width, 2) << " setlinewidth\n";
  }
  // a path may have so many points on every printer
  constexpr int kMostPoints = 1000;
  const Segment* before = nullptr;
  int points = 0;
  for (const std::uint32_t index : lines.segments) {
    const Segment& segment = scene_.segments[index];
    const PagePlace a = page_.place(segment.start);
    const PagePlace b = page_.place(segment.end);
    if (lines.width == 0.0) {
      point(a).number(page_.radius(segment, false), 2) << ' ';
      point(b).number(page_.radius(segment, true), 2) << " t\n";
      continue;
    }
    if (before == nullptr || before->end != segment.start || points >= kMostPoints) {
      out_ << (before != nullptr ? "s\n" : "");
      point(a) << "m ";
      points = 0;
    }
    point(b) << "l ";
    ++points;
    before = &segment;
  }
  out_ << (before != nullptr ? "s\n" : "");
}

void PostScriptWriter::writeText(const std::string& text) {
  out_ << '(';
  for (const char c : text) {
    if (c == '(' || c == ')' || c == '\\') {
      out_ << '\\' << c;
    } else if (c >= ' ' && c <= '~') {
      out_ << c;
    }
  }
  out_ << ") show\n";
}

void PostScriptWriter::writeShape(const PageShape& shape) {
  writeColour(shape.colour);
  switch (shape.kind) {
    case PageShape::Kind::Face:
      for (std::uint32_t k = 0; k < shape.pointCount; ++k) {
        point(page_.point(shape, k)) << (k == 0 ? "m " : "l ");
      }
      out_ << "f\n";
      return;
    case PageShape::Kind::Sphere:
    case PageShape::Kind::Disc:
      point(page_.point(shape, 0)).number(shape.radius, 2) << " d\n";
      return;
    case PageShape::Kind::Text:
      point(page_.point(shape, 0)) << "m ";
      writeText(scene_.labels[shape.label].text);
      return;
  }
}

}  // namespace

void writePostScript(const Scene& scene, const files::ViewSettings& view, const PostScriptOptions& options,
                     core::ByteSink& sink) {
  constexpr double kMargin = 0.03;
  const Palette palette(scene, view, options.palette);
  const PageDrawing page(scene, view, palette, options.widthPoints, options.heightPoints, kMargin, options.frame);
  TextOutput out(sink);
  PostScriptWriter writer(scene, page, out);
  writer.writeHead(view.postScriptLineCap);
  for (const PageLines& lines : page.lines()) {
    writer.writeLines(lines);
  }
  for (const PageShape& shape : page.shapes()) {
    writer.writeShape(shape);
  }
  out << "grestore\nshowpage\n%%EOF\n";
  out.flush();
}

}  // namespace espalier::turtle
