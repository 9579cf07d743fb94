#include "host-tools/compiler/compile.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "board/files/text_file.h"
#include "control/scene/check.h"
#include "control/scene/limits.h"
#include "control/scene/shape_table.h"
#include "host-tools/compiler/compile_help.h"
#include "host-tools/compiler/height_grid.h"
#include "host-tools/compiler/mesh_file.h"
#include "host-tools/compiler/mesh_pieces.h"
#include "host-tools/compiler/scene_errors.h"
#include "host-tools/compiler/scene_file.h"
#include "host-tools/compiler/to_scene.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

void tell(const std::string& object, double share) {
  if (const auto& progress = compile_help().progress) progress(object, share);
}

class ImageWriter {
 public:
  // known: of the scene's last compilation, if any.
  ImageWriter(std::filesystem::path folder, SceneReport& report, const CompiledParts* known)
      : folder_(std::move(folder)), report_(report), known_(known) {}

  std::vector<std::byte> write(const SceneFile& file, const std::string& name, SceneIssues& issues) {
    std::vector<flatbuffers::Offset<scene::Object>> objects;
    for (std::size_t i = 0; i < file.objects.size(); ++i) {
      try {
        objects.push_back(write_object(file.objects[i]));
      } catch (const Error& error) {
        issues.add(error, "/objects/" + std::to_string(i));
        builder_
            .Clear();  // it may be in the middle of something; the other objects are compiled for their errors
      }
    }
    if (!issues.empty()) issues.raise();
    refuse_what_does_not_meet(file);
    const auto scene_name = builder_.CreateString(file.name);
    const scene::Vec3 gravity = to_scene(file.gravity_m_s2);
    builder_.Finish(scene::CreateScene(builder_, scene_name, builder_.CreateVector(objects),
                                       file.gravity_m_s2.isZero() ? nullptr : &gravity,
                                       static_cast<float>(file.tip_radius_m)),
                    scene::SceneIdentifier());
    if (builder_.GetSize() > control::kMaxImageBytes) {
      throw Error(ExitCode::kBadInput, "image-too-large",
                  name + ": the scene image has " + std::to_string(builder_.GetSize()) + " bytes, at most " +
                      std::to_string(control::kMaxImageBytes) + " are allowed",
                  "simplify the meshes");
    }
    std::vector<std::byte> image(builder_.GetSize());
    std::memcpy(image.data(), builder_.GetBufferPointer(), image.size());
    return image;
  }

  // That the image was made of.
  [[nodiscard]] CompiledParts take_parts() { return std::move(parts_); }

 private:
  using AnyShape = std::pair<scene::Shape, flatbuffers::Offset<void>>;

  flatbuffers::Offset<scene::Object> write_object(const SceneObject& object) {
    report_.objects.push_back({object.name, object.shape_word, {}});
    object_ = &object;
    const struct Told {
      const std::string& name;
      explicit Told(const std::string& object_name) : name(object_name) { tell(name, 0.0); }
      Told(const Told&) = delete;
      Told& operator=(const Told&) = delete;
      ~Told() { tell(name, 1.0); }
    } told(object.name);
    pieces_.push_back(1);
    const AnyShape shape = std::visit([&](const auto& each) { return write_shape(each); }, object.shape);
    const auto name = builder_.CreateString(object.name);
    const auto cast = [](double value) { return static_cast<float>(value); };
    const Eigen::Quaterniond& q = object.rotation;
    const scene::Pose pose(to_scene(object.position_m),
                           scene::Quat(cast(q.w()), cast(q.x()), cast(q.y()), cast(q.z())));
    const SceneMaterial& m = object.material;
    const scene::Material material(cast(m.stiffness_N_m), cast(m.damping_N_s_m), cast(m.static_friction),
                                   cast(m.dynamic_friction), m.friction_mode);
    const auto* primitive = std::get_if<PrimitiveShape>(&object.shape);
    const Wearer wearer{object.name, object.shape_word, shape.first,
                        primitive != nullptr ? primitive->unrolled_radius_m : 0.0};
    if (m.surface.texture) note_file(m.surface.texture->heights.file);
    if (const auto& map = m.surface.stiffness_map) {
      note_file(map->stiffness_N_m.file);
      if (map->damping_N_s_m) note_file(map->damping_N_s_m->file);
    }
    const auto surface = write_surface(builder_, m.surface, wearer, folder_, report_.warnings);
    const float stiffest_N_m = control::stiffest_N_m(
        material.stiffness_n_per_m(),
        surface.IsNull() ? nullptr : flatbuffers::GetTemporaryPointer(builder_, surface));
    const auto body = object.body
                          ? write_body(builder_, *object.body, mass_, static_cast<double>(stiffest_N_m),
                                       object.position_m, object.rotation)
                          : 0;
    return scene::CreateObject(builder_, name, shape.first, shape.second, &pose, &material, surface, body);
  }

  void note_file(const std::string& file) {
    if (!file.empty()) report_.files.push_back(folder_ / file);
  }

  AnyShape write_shape(const NeedleShape& needle) { return host::write_shape(builder_, needle); }
  AnyShape write_shape(const TissueShape& tissue) { return host::write_shape(builder_, tissue); }
  AnyShape write_shape(const VectorFieldShape& field) { return host::write_shape(builder_, field); }
  AnyShape write_shape(const PotentialFieldShape& field) {
    const std::string key = potential_key(field.problem);
    std::shared_ptr<const std::vector<float>>& coefficients = parts_.potentials[key];
    if (known_ != nullptr && known_->potentials.contains(key)) coefficients = known_->potentials.at(key);
    if (coefficients == nullptr) {
      coefficients = std::make_shared<const std::vector<float>>(
          solved_coefficients(field, [this](double share) { tell(object_->name, share); }));
    }
    return host::write_shape(builder_, field, *coefficients);
  }
  AnyShape write_shape(const PrimitiveShape& primitive) {
    mass_ = {Eigen::Vector3d::Zero(), primitive.unit_inertia_m2.asDiagonal()};
    return {object_->kind, primitive.write(builder_)};
  }

  AnyShape write_shape(const MeshShape& shape) {
    const std::string name = shape.place + ": " + shape.file;
    note_file(shape.file);
    return write_mesh(read_mesh_file(folder_ / shape.file, shape.scale_m, name), shape.options, shape.file,
                      name);
  }
  AnyShape write_shape(const HeightFieldShape& shape) {
    const std::string name = shape.place + ": " + shape.file;
    note_file(shape.file);
    const HeightGrid grid = read_height_grid(folder_ / shape.file, control::kMaxHeightSamples, name);
    const MeshOptions options{
        .side = MeshSide::kOutside, .crease_deg = shape.crease_deg, .height_field = true};
    return write_mesh(height_field_soup(shape, grid, name), options, shape.file, name);
  }

  std::shared_ptr<const CompiledParts::Mesh> compiled(TriangleSoup soup, MeshOptions options,
                                                      const std::string& name) {
    const bool in_pieces = object_->body.has_value();
    if (known_ != nullptr) {
      for (const std::shared_ptr<const CompiledParts::Mesh>& each : known_->meshes)
        if (each->in_pieces == in_pieces && is_same(each->options, options) && is_same(each->soup, soup))
          return each;
    }
    CompiledParts::Mesh part{std::move(soup), options, in_pieces, {}, {}};
    options.progress = [this](double share) { tell(object_->name, share); };
    part.mesh = compile_mesh(part.soup, options, name);
    if (in_pieces) part.pieces = convex_pieces(part.mesh);
    return std::make_shared<const CompiledParts::Mesh>(std::move(part));
  }

  AnyShape write_mesh(TriangleSoup soup, const MeshOptions& options, const std::string& file,
                      const std::string& name) {
    MeshOptions in_scene = options;
    in_scene.tip_radius_m = report_.tip_radius_m;
    if (const auto& texture = object_->material.surface.texture)
      in_scene.texture = MeshTexture{texture->mapping, texture->tile_m};
    parts_.meshes.push_back(compiled(std::move(soup), std::move(in_scene), name));
    const CompiledMesh& mesh = parts_.meshes.back()->mesh;
    triangles_ += mesh.triangles.size();
    if (triangles_ > control::kMaxTriangles) {
      throw Error(ExitCode::kBadInput, "too-many-triangles",
                  name + ": with this mesh the scene has " + std::to_string(triangles_) +
                      " triangles, at most " + std::to_string(control::kMaxTriangles) + " are allowed",
                  "simplify the meshes");
    }
    warn(mesh.report, file);
    if (object_->body) weigh(mesh, file);
    report_.objects.back().mesh = mesh.report;

    const auto vertices = builder_.CreateVectorOfStructs(mesh.vertices);
    const auto triangles = builder_.CreateVectorOfStructs(mesh.triangles);
    const auto flags = builder_.CreateVector(mesh.flags);
    const auto corners = mesh.corner_normals.empty() ? 0 : builder_.CreateVector(mesh.corner_normals);
    const auto nodes = builder_.CreateVectorOfStructs(mesh.nodes);
    const auto weights = mesh.texture_weights.empty() ? 0 : builder_.CreateVector(mesh.texture_weights);
    const auto texture_corners =
        mesh.texture_corners.empty() ? 0 : builder_.CreateVector(mesh.texture_corners);
    const auto texture_points =
        mesh.texture_points.empty() ? 0 : builder_.CreateVectorOfStructs(mesh.texture_points);
    const auto [piece_corners, piece_ends] = write_pieces(parts_.meshes.back()->pieces);
    const auto rims = mesh.rims.empty() ? 0 : builder_.CreateVector(mesh.rims);
    return {scene::Shape::Mesh,
            scene::CreateMesh(builder_, vertices, triangles, flags, corners, nodes, &mesh.grid_origin_m,
                              mesh.grid_step_m, mesh.depth, weights, texture_corners, texture_points,
                              piece_corners, piece_ends, mesh.seams, rims)
                .Union()};
  }

  // Of a mesh that moves.
  using PieceCorners = flatbuffers::Offset<flatbuffers::Vector<const scene::Vec3*>>;
  using PieceEnds = flatbuffers::Offset<flatbuffers::Vector<std::uint16_t>>;
  std::pair<PieceCorners, PieceEnds> write_pieces(const MeshPieces& pieces) {
    if (!object_->body) return {0, 0};
    pieces_.back() = pieces.corners_m.size();
    if (pieces.corners_m.empty()) return {0, 0};
    std::vector<scene::Vec3> corners;
    std::vector<std::uint16_t> ends;
    for (const std::vector<Eigen::Vector3d>& piece : pieces.corners_m) {
      for (const Eigen::Vector3d& p : piece) corners.push_back(to_scene(p));
      ends.push_back(static_cast<std::uint16_t>(corners.size()));
    }
    constexpr double kRough = .05;  // of the volume
    if (pieces.excess > kRough) {
      report_.warnings.push_back(object_->name + ": other objects meet it as " + std::to_string(ends.size()) +
                                 " convex pieces with " + number(std::round(100 * pieces.excess)) +
                                 " % more volume");
    }
    return {builder_.CreateVectorOfStructs(corners), builder_.CreateVector(ends)};
  }

  // Everything with a surface that a body could lie on or be hit by collides with it, or the scene is refused. A field has no surface.
  void refuse_what_does_not_meet(const SceneFile& file) {
    const auto refuse = [](const SceneObject& body, const SceneObject& other, const std::string& why,
                           const std::string& remedy) {
      throw Error(ExitCode::kBadInput, "objects-do-not-meet",
                  "the body " + body.name + " would go through " + other.name + ": " + why, remedy);
    };
    for (std::size_t i = 0; i < file.objects.size(); ++i) {
      const SceneObject& body = file.objects[i];
      if (!body.body) continue;
      const bool guided =
          body.body->motion == scene::Motion::Slide || body.body->motion == scene::Motion::Turn;
      for (std::size_t j = 0; j < file.objects.size(); ++j) {
        const SceneObject& other = file.objects[j];
        if (i == j) continue;
        const bool is_tissue = other.kind == scene::Shape::Tissue;
        const bool is_field = other.kind == scene::Shape::VectorField ||
                              other.kind == scene::Shape::PotentialField ||
                              other.kind == scene::Shape::ForceField;
        if (is_field) {
          if (!guided)
            report_.warnings.push_back(other.name + " acts on fingertips only: the body " + body.name +
                                       " passes through it");
        } else if (control::is_volume(other.kind) && !is_tissue) {
          if (!guided)
            refuse(body, other, "the skin of a " + other.shape_word + " acts on fingertips only",
                   "make it a tissue or a solid, or let the body slide or turn");
        } else if (is_tissue &&
                   static_cast<double>(std::get<TissueShape>(other.shape).image.relaxed_stiffness_n_per_m()) >
                       static_cast<double>(control::kMaxStiffnessPerMass_1_s2) * body.body->mass_kg) {
          refuse(body, other, "the tissue is too stiff for a mass of " + number(body.body->mass_kg) + " kg",
                 "make the body heavier or the tissue softer");
        } else if (pieces_[i] == 0) {
          refuse(body, other, "its mesh encloses no volume, so it has no convex pieces",
                 "close the mesh (thimble mesh FILE --output FIXED), with \"side\": \"outside\"");
        }
      }
    }
  }

  // A moving mesh. An open one has no volume, but a surface.
  void weigh(const CompiledMesh& mesh, const std::string& file) {
    const std::optional<ShapeMass> volume = volume_mass(mesh);
    mass_ = volume ? *volume : surface_mass(mesh);
    const SceneBody& body = *object_->body;
    const bool needed = rotates(body.motion) && !(body.centre_m && body.inertia_kg_m2);
    if (volume || !needed) return;
    report_.warnings.push_back(
        object_->name + " (" + file +
        "): the mesh encloses no volume, so its mass is spread evenly over its surface");
  }

  void warn(const MeshReport& mesh, const std::string& file) {
    const auto add = [&](std::size_t count, const char* one, const char* many) {
      if (count > 0) {
        report_.warnings.push_back(report_.objects.back().name + " (" + file +
                                   "): " + (count == 1 ? one : std::to_string(count) + many));
      }
    };
    add(mesh.degenerate_dropped, "a triangle without area was dropped",
        " triangles without area were dropped");
    add(mesh.fins_cancelled, "a face with its own reverse, which encloses nothing, was dropped",
        " faces with their own reverse, which enclose nothing, were dropped");
    // A file whose faces were not all read, such as one of strips.
    constexpr std::size_t kFew = 100, kUsedShare = 10;
    if (mesh.unused_vertices > kFew && mesh.unused_vertices > kUsedShare * mesh.vertices) {
      add(mesh.unused_vertices, "",
          " vertices of the file belong to no triangle: were all of its faces read?");
    }
    add(mesh.open_edges, "an open edge: what hangs together with it is solid from either side",
        " open edges: what hangs together with them is solid from either side");
    add(mesh.non_manifold_edges, "an edge has more than two faces", " edges have more than two faces");
    add(mesh.flipped_components, "a closed part was wound inside out and has been turned",
        " closed parts were wound inside out and have been turned");
    add(mesh.pierced_triangles, "a triangle crosses another one", " triangles cross others");
    if (mesh.texture_tiles[0] != 0) warn_of_coordinates(mesh, file);
  }

  // The size of a tile is not exactly that of the scene file.
  void warn_of_coordinates(const MeshReport& mesh, const std::string& file) {
    const auto mm = [](double length_m) { return number(std::round(1.0e5 * length_m) / 100.0); };
    std::string text = report_.objects.back().name + " (" + file +
                       "): " + std::to_string(mesh.texture_tiles[0]) + " x " +
                       std::to_string(mesh.texture_tiles[1]) +
                       " tiles of the texture fill a unit of the file's texture coordinates, in the mean " +
                       mm(mesh.texture_tile_m[0]) + " x " + mm(mesh.texture_tile_m[1]) + " mm each";
    constexpr double kSeen = 0.01;
    if (mesh.texture_faded >= kSeen)
      text += ", and fade towards seams on " + number(std::round(100.0 * mesh.texture_faded)) +
              " % of the surface";
    report_.warnings.push_back(text);
  }

  flatbuffers::FlatBufferBuilder builder_;
  std::filesystem::path folder_;
  SceneReport& report_;
  const CompiledParts* known_;
  CompiledParts parts_;
  std::size_t triangles_ = 0;
  const SceneObject* object_ = nullptr;  // being written
  std::vector<std::size_t> pieces_;      // convex, of each object; 1 for all but meshes
  ShapeMass mass_;                       // of its shape
};

}  // namespace

CompiledScene compile_scene_text(const std::string& text, const std::string& name,
                                 const std::filesystem::path& folder, const CompiledParts* known) {
  const SceneFile file = read_scene_file(text, name);
  CompiledScene compiled;
  compiled.report.name = file.name;
  compiled.report.tip_radius_m = file.tip_radius_m;
  ImageWriter writer(folder, compiled.report, known);
  SceneIssues issues(text, name);
  try {
    compiled.image = writer.write(file, name, issues);
  } catch (const SceneErrors&) {
    throw;
  } catch (const Error& error) {
    issues.add(error);
    issues.raise();
  }
  compiled.parts = std::make_shared<const CompiledParts>(writer.take_parts());
  compiled.report.bytes = compiled.image.size();
  if (file.objects.empty()) {
    compiled.report.warnings.emplace_back("the scene has no object: there is nothing to touch");
  }
  return compiled;
}

CompiledScene compile_scene(const std::filesystem::path& scene_file) {
  try {
    if (board::size_of_file(scene_file))
      return compile_scene_text(board::read_text(scene_file), scene_file.string(), scene_file.parent_path());
  } catch (const board::FileError&) {  // as if it were not there
  }
  throw Error(ExitCode::kBadInput, "missing-scene", scene_file.string() + ": the scene file cannot be opened",
              "give the path of a scene file, such as scenes/asteroid/asteroid.scene.json");
}

}  // namespace thimble::host
