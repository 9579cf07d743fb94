#include "host-tools/compiler/mesh_file.h"

#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <limits>
#include <sstream>
#include <utility>

#include "board/files/text_file.h"
#include "control/scene/limits.h"
#include "host-tools/compiler/plg.h"
#include "host-tools/compiler/polygon.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr std::size_t kHeadBytes = std::size_t{1} << 20U;  // more than any header has
constexpr std::uintmax_t kMaxMeshBytes = std::uintmax_t{1} << 30U;

Error bad_file(const std::string& slug, const std::string& cause, const std::string& remedy) {
  return Error(ExitCode::kBadInput, slug, cause, remedy);
}

// Assimp believes the counts in an OFF header ("OFF 8 6 12") or a PLY header ("element vertex 8") and takes
// the memory at once; none can exceed the file's bytes. Of a PLY file's triangle strips it reads the first triangle.
void check_header(std::istream& stream, bool ply, std::uintmax_t bytes, const std::string& name) {
  constexpr int kHeaderLines = 1000;
  constexpr int kOffCounts = 3;
  std::string line;
  int counts = 0;
  for (int i = 0; i < kHeaderLines && std::getline(stream, line); ++i) {
    if (ply && line.find("end_header") != std::string::npos) {
      return;
    }
    if (ply ? !line.starts_with("element") : line.starts_with("#")) {
      continue;
    }
    if (ply && line.starts_with("element tristrips")) {
      throw bad_file("triangle-strips", name + ": the file's faces are triangle strips, which are not read",
                     "convert its faces to triangles, for example with MeshLab");
    }
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      if (!std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; })) {
        continue;
      }
      if (!ply && ++counts > kOffCounts) {
        return;
      }
      if (word.size() > 18 || std::stoull(word) > bytes) {
        std::string cause = name;
        cause.append(": the header announces ").append(word).append(" elements, but the file has ");
        cause.append(std::to_string(bytes)).append(" bytes");
        throw bad_file("unreadable-mesh", cause, "repair the mesh file");
      }
    }
  }
  if (ply) {
    throw bad_file("unreadable-mesh", name + ": the PLY header has no \"end_header\"",
                   "repair the mesh file");
  }
}

Error broken_scene(const std::string& name, const std::string& what) {
  return bad_file("unreadable-mesh",
                  name + ": assimp reads the file, but gives a broken scene (" + what + ")",
                  "convert the mesh to another format, such as OBJ or PLY");
}

void append_vertices(const aiMesh& mesh, const aiMatrix4x4& to_file, TriangleSoup& soup) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D p = to_file * mesh.mVertices[v];
    soup.vertices_m.emplace_back(p.x, p.y, p.z);
    if (mesh.HasTextureCoords(0)) {
      soup.vertices_uv.emplace_back(mesh.mTextureCoords[0][v].x, mesh.mTextureCoords[0][v].y);
    } else {
      soup.vertices_uv.emplace_back(kNone, kNone);
    }
  }
}

TriangleSoup read_by_assimp(const std::filesystem::path& file, const std::string& name) {
  Assimp::Importer importer;
  const aiScene* scene = nullptr;
  std::string refusal;
  try {
    scene = importer.ReadFile(file.string(),
                              0);  // no steps of assimp's own: some of them end the process on bad input
    refusal = importer.GetErrorString();
  } catch (const std::exception& error) {
    refusal = error.what();
  }
  if (scene == nullptr || scene->mRootNode == nullptr) {
    while (!refusal.empty() && std::isspace(static_cast<unsigned char>(refusal.back())) != 0) {
      refusal.pop_back();
    }
    throw bad_file(
        "unreadable-mesh", name + ": assimp cannot read the file: " + refusal,
        "give a mesh that assimp reads (OBJ, STL, PLY, OFF, glTF ...) with the side files it names, or a "
        "REND386 .plg");
  }
  TriangleSoup soup;
  struct Visit {
    const aiNode* node;
    aiMatrix4x4 parent;
  };
  std::vector<Visit> open{{scene->mRootNode, aiMatrix4x4()}};
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    if (visit.node == nullptr) {  // seen with RAW files of several objects
      throw broken_scene(name, "a node without content");
    }
    const aiMatrix4x4 to_file = visit.parent * visit.node->mTransformation;
    const bool mirrors = to_file.Determinant() < 0;
    for (unsigned m = 0; m < visit.node->mNumMeshes; ++m) {
      if (visit.node->mMeshes[m] >= scene->mNumMeshes || scene->mMeshes[visit.node->mMeshes[m]] == nullptr) {
        throw broken_scene(name, "a node names a mesh that does not exist");
      }
      const aiMesh& mesh = *scene->mMeshes[visit.node->mMeshes[m]];
      const auto base = static_cast<std::uint32_t>(soup.vertices_m.size());
      append_vertices(mesh, to_file, soup);
      for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        const aiFace& face = mesh.mFaces[f];
        std::vector<std::uint32_t> polygon(face.mIndices, face.mIndices + face.mNumIndices);
        if (polygon.size() < 3) {
          continue;  // points and lines
        }
        if (polygon.size() > kMaxPolygonPoints) {
          throw bad_file("too-many-points",
                         name + ": a face has " + std::to_string(polygon.size()) + " points, at most " +
                             std::to_string(kMaxPolygonPoints) + " are allowed",
                         "cut the mesh's faces into triangles");
        }
        if (*std::max_element(polygon.begin(), polygon.end()) >= mesh.mNumVertices) {
          throw broken_scene(name, "a face names a vertex that does not exist");
        }
        for (std::uint32_t& index : polygon) {
          index += base;
        }
        if (mirrors) {
          std::reverse(polygon.begin(), polygon.end());
        }
        append_polygon(std::move(polygon), soup);
      }
      if (soup.triangles.size() > control::kMaxTriangles) {
        throw bad_file("too-many-triangles",
                       name + ": more than " + std::to_string(control::kMaxTriangles) + " triangles",
                       "simplify the mesh");
      }
    }
    for (unsigned c = visit.node->mNumChildren; c > 0; --c) {  // the first child is visited first
      open.push_back({visit.node->mChildren[c - 1], to_file});
    }
  }
  if (std::ranges::none_of(soup.vertices_uv, [](const Eigen::Vector2d& uv) { return uv.allFinite(); }))
    soup.vertices_uv.clear();
  return soup;
}

}  // namespace

TriangleSoup read_mesh_file(const std::filesystem::path& file, double scale_m, const std::string& name) {
  const std::optional<std::uintmax_t> bytes = board::size_of_file(file);
  if (!bytes) {
    throw bad_file("missing-mesh", name + ": there is no such file (" + file.string() + ")",
                   "give the path of a mesh file, relative to the scene file");
  }
  if (*bytes > kMaxMeshBytes) {
    throw bad_file("mesh-file-too-large",
                   name + ": the file has " + std::to_string(*bytes) + " bytes, at most " +
                       std::to_string(kMaxMeshBytes) + " are allowed",
                   "simplify the mesh");
  }
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  TriangleSoup soup;
  const bool is_plg = extension == ".plg", is_ply = extension == ".ply";
  try {
    if (is_plg) soup = read_plg(board::read_text(file), name);
    if (is_ply || extension == ".off") {
      std::istringstream head(board::read_head(file, kHeadBytes));
      check_header(head, is_ply, *bytes, name);
    }
  } catch (const board::FileError&) {
    throw bad_file("unreadable-mesh", name + ": the file cannot be opened", "check the file's permissions");
  }
  if (!is_plg) soup = read_by_assimp(file, name);
  if (soup.triangles.empty()) {
    throw bad_file("empty-mesh", name + ": the file has no face", "give a mesh with at least one face");
  }
  for (Eigen::Vector3d& p : soup.vertices_m) {
    p *= scale_m;
  }
  return soup;
}

}  // namespace thimble::host
