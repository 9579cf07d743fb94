#include "host-tools/compiler/plg.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "control/scene/limits.h"
#include "host-tools/compiler/polygon.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using Tokens = std::vector<std::string_view>;

constexpr std::string_view kBlanks = " \t\r\f\v,";

template <typename Number>
std::optional<Number> parse(std::string_view token, int base = 10) {
  if (!token.empty() && token.front() == '+') {
    token.remove_prefix(1);
  }
  Number value{};
  std::from_chars_result result{};
  if constexpr (std::is_floating_point_v<Number>) {
    result = std::from_chars(token.data(), token.data() + token.size(), value);
  } else {
    result = std::from_chars(token.data(), token.data() + token.size(), value, base);
  }
  if (result.ec != std::errc() || result.ptr != token.data() + token.size()) {
    return std::nullopt;
  }
  return value;
}

bool is_colour(std::string_view token) {
  if (token.starts_with("0x") || token.starts_with("0X")) {
    return parse<unsigned long>(token.substr(2), 16).has_value();
  }
  for (const std::string_view surface : {"indexed_", "shaded_", "metal_", "glass_"}) {
    if (token.starts_with(surface)) {
      return true;
    }
  }
  return parse<long>(token).has_value();
}

// The lines with content, without comments.
class Lines {
 public:
  Lines(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

  // The tokens of the next line that has any; empty at the end of the file.
  Tokens next() {
    while (at_ < text_.size()) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      std::string_view line = text_.substr(at_, end - at_);
      at_ = end + 1;
      ++line_;
      const std::size_t comment = line.find_first_of("#*;");
      if (comment != std::string_view::npos) {
        const std::size_t word = line.find_first_not_of('#', comment);
        multi_ = multi_ || (word != std::string_view::npos && line.substr(word).starts_with("MULTI"));
        line = line.substr(0, comment);
      }
      Tokens tokens;
      for (std::size_t i = line.find_first_not_of(kBlanks); i != std::string_view::npos;
           i = line.find_first_not_of(kBlanks, i)) {
        const std::size_t stop = std::min(line.find_first_of(kBlanks, i), line.size());
        tokens.push_back(line.substr(i, stop - i));
        i = stop;
      }
      if (!tokens.empty()) {
        return tokens;
      }
    }
    return {};
  }

  [[nodiscard]] bool multi() const { return multi_; }

  [[noreturn]] void fail(const std::string& cause) const {
    throw Error(ExitCode::kBadInput, "bad-plg", name_ + ":" + std::to_string(line_) + ": " + cause,
                "a .plg mesh is a REND386 file: a header \"name vertices facets\", vertex lines \"x y z\", "
                "facet lines "
                "\"colour n i1 .. in\"");
  }

 private:
  std::string_view text_;
  std::string name_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
  bool multi_ = false;
};

std::string quoted(std::string_view token) {
  return std::string("\"").append(token.substr(0, 40)).append("\"");
}

TriangleSoup read_object(Lines& lines, const Tokens& header) {
  const auto vertex_count = header.size() >= 3 ? parse<std::uint32_t>(header[1]) : std::nullopt;
  const auto facet_count = header.size() >= 3 ? parse<std::uint32_t>(header[2]) : std::nullopt;
  if (!vertex_count || !facet_count) {
    lines.fail("expected an object's header \"name vertices facets\", found " + quoted(header[0]));
  }
  const std::uint32_t vertices = *vertex_count;
  const std::uint32_t facets = *facet_count;
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < vertices; ++i) {
    const Tokens line = lines.next();
    if (line.empty()) {
      lines.fail("the file ends at vertex " + std::to_string(i) + " of " + std::to_string(vertices));
    }
    Eigen::Vector3d at;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      const auto value = k < line.size() ? parse<double>(line[k]) : std::nullopt;
      if (!value || !std::isfinite(*value)) {
        lines.fail("vertex " + std::to_string(i) + " of " + std::to_string(vertices) +
                   ": expected three numbers, found " + quoted(k < line.size() ? line[k] : "the line's end"));
      }
      at[axis] = axis == 2 ? -*value : *value;
    }
    soup.vertices_m.push_back(at);
  }
  for (std::uint32_t i = 0; i < facets; ++i) {
    const Tokens line = lines.next();
    const std::string facet = "facet " + std::to_string(i) + " of " + std::to_string(facets);
    if (line.empty()) {
      lines.fail("the file ends at " + facet);
    }
    const std::size_t size = line.size() >= 2 ? parse<std::uint32_t>(line[1]).value_or(0) : 0;
    if (!is_colour(line[0]) || size == 0 || size > kMaxPolygonPoints) {
      lines.fail(facet + ": expected a colour and a number of points from 1 to " +
                 std::to_string(kMaxPolygonPoints) + ", found " + quoted(line[0]) +
                 (line.size() > 1 ? " " + quoted(line[1]) : ""));
    }
    if (line.size() < 2 + size) {
      lines.fail(facet + ": " + std::to_string(size) + " points announced, " +
                 std::to_string(line.size() - 2) + " given");
    }
    std::vector<std::uint32_t> polygon;
    for (std::size_t k = 0; k < size; ++k) {
      const auto index = parse<std::uint32_t>(line[2 + k]);
      if (!index || *index >= vertices) {
        lines.fail(facet + ": vertex " + quoted(line[2 + k]) + " does not exist, there are " +
                   std::to_string(vertices) + ", numbered from 0");
      }
      polygon.push_back(*index);
    }
    append_polygon(std::move(polygon), soup);
    if (soup.triangles.size() > control::kMaxTriangles) {
      lines.fail("more than " + std::to_string(control::kMaxTriangles) + " triangles");
    }
  }
  return soup;
}

void append(TriangleSoup& all, const TriangleSoup& more) {
  const auto base = static_cast<std::uint32_t>(all.vertices_m.size());
  all.vertices_m.insert(all.vertices_m.end(), more.vertices_m.begin(), more.vertices_m.end());
  for (const auto& t : more.triangles) {
    all.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
}

}  // namespace

TriangleSoup read_plg(std::string_view text, const std::string& name) {
  if (text.starts_with("\xEF\xBB\xBF")) {
    text.remove_prefix(3);
  }
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '<') {
    throw Error(
        ExitCode::kBadInput, "not-a-rend386-plg",
        name + ": this .plg is an HTML or XML document (such as a build log), not a REND386 polygon file",
        "give the mesh's own file; other programs use the ending .plg too");
  }
  if (text.find('\0') != std::string_view::npos) {
    throw Error(ExitCode::kBadInput, "not-a-rend386-plg",
                name + ": this .plg is a binary file, not a REND386 polygon file",
                "give the mesh's own file; other programs use the ending .plg too");
  }
  Lines lines(text, name);
  TriangleSoup all;
  TriangleSoup finest;
  for (Tokens header = lines.next(); !header.empty(); header = lines.next()) {
    const TriangleSoup object = read_object(lines, header);
    if (object.triangles.size() > finest.triangles.size()) {
      finest = object;
    }
    append(all, object);
  }
  TriangleSoup& soup = lines.multi() ? finest : all;
  if (soup.triangles.empty()) {
    throw Error(ExitCode::kBadInput, "empty-mesh", name + ": the file has no facet of three or more points",
                "give a mesh with at least one face");
  }
  return std::move(soup);
}

}  // namespace thimble::host
