#include "host-tools/compiler/compile.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

#include "control/scene/check.h"
#include "control/scene/limits.h"
#include "host-tools/compiler/height_grid.h"
#include "host-tools/compiler/mesh_file.h"
#include "host-tools/compiler/scene_file.h"
#include "host-tools/compiler/to_scene.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

class ImageWriter {
 public:
  ImageWriter(std::filesystem::path folder, SceneReport& report)
      : folder_(std::move(folder)), report_(report) {}

  std::vector<std::byte> write(const SceneFile& file, const std::string& name) {
    std::vector<flatbuffers::Offset<scene::Object>> objects;
    for (const SceneObject& object : file.objects) {
      objects.push_back(write_object(object));
    }
    warn_of_meshes_that_bodies_pass(file);
    const auto scene_name = builder_.CreateString(file.name);
    const scene::Vec3 gravity = to_scene(file.gravity_m_s2);
    builder_.Finish(scene::CreateScene(builder_, scene_name, builder_.CreateVector(objects),
                                       file.gravity_m_s2.isZero() ? nullptr : &gravity),
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

 private:
  using AnyShape = std::pair<scene::Shape, flatbuffers::Offset<void>>;

  flatbuffers::Offset<scene::Object> write_object(const SceneObject& object) {
    report_.objects.push_back({object.name, object.shape_word, {}});
    object_ = &object;
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
    const auto surface = write_surface(builder_, m.surface, wearer, folder_, report_.warnings);
    const float stiffest_N_m = control::stiffest_N_m(
        material.stiffness_n_per_m(),
        surface.IsNull() ? nullptr : flatbuffers::GetTemporaryPointer(builder_, surface));
    const auto body = object.body
                          ? write_body(builder_, *object.body, unit_inertia_,
                                       static_cast<double>(stiffest_N_m), object.position_m, object.rotation)
                          : 0;
    return scene::CreateObject(builder_, name, shape.first, shape.second, &pose, &material, surface, body);
  }

  AnyShape write_shape(const NeedleShape& needle) { return host::write_shape(builder_, needle); }
  AnyShape write_shape(const TissueShape& tissue) { return host::write_shape(builder_, tissue); }
  AnyShape write_shape(const VectorFieldShape& field) { return host::write_shape(builder_, field); }
  AnyShape write_shape(const PotentialFieldShape& field) { return host::write_shape(builder_, field); }
  AnyShape write_shape(const PrimitiveShape& primitive) {
    unit_inertia_ = primitive.unit_inertia_m2;
    return {object_->kind, primitive.write(builder_)};
  }

  AnyShape write_shape(const MeshShape& shape) {
    const std::string name = shape.place + ": " + shape.file;
    return write_mesh(read_mesh_file(folder_ / shape.file, shape.scale_m, name), shape.options, shape.file,
                      name);
  }
  AnyShape write_shape(const HeightFieldShape& shape) {
    const std::string name = shape.place + ": " + shape.file;
    const HeightGrid grid = read_height_grid(folder_ / shape.file, control::kMaxHeightSamples, name);
    const MeshOptions options{
        .side = MeshSide::kOutside, .crease_deg = shape.crease_deg, .height_field = true};
    return write_mesh(height_field_soup(shape, grid, name), options, shape.file, name);
  }

  AnyShape write_mesh(const TriangleSoup& soup, const MeshOptions& options, const std::string& file,
                      const std::string& name) {
    const CompiledMesh mesh = compile_mesh(soup, options, name);
    triangles_ += mesh.triangles.size();
    if (triangles_ > control::kMaxTriangles) {
      throw Error(ExitCode::kBadInput, "too-many-triangles",
                  name + ": with this mesh the scene has " + std::to_string(triangles_) +
                      " triangles, at most " + std::to_string(control::kMaxTriangles) + " are allowed",
                  "simplify the meshes");
    }
    warn(mesh.report, file);
    if (object_->body) weigh(mesh, file, name);
    report_.objects.back().mesh = mesh.report;

    const auto vertices = builder_.CreateVectorOfStructs(mesh.vertices);
    const auto triangles = builder_.CreateVectorOfStructs(mesh.triangles);
    const auto flags = builder_.CreateVector(mesh.flags);
    const auto corners = mesh.corner_normals.empty() ? 0 : builder_.CreateVector(mesh.corner_normals);
    const auto nodes = builder_.CreateVectorOfStructs(mesh.nodes);
    return {scene::Shape::Mesh, scene::CreateMesh(builder_, vertices, triangles, flags, corners, nodes,
                                                  &mesh.grid_origin_m, mesh.grid_step_m, mesh.depth)
                                    .Union()};
  }

  void warn_of_meshes_that_bodies_pass(const SceneFile& file) {
    const auto moves = [](const SceneObject& object) { return object.body.has_value(); };
    if (std::none_of(file.objects.begin(), file.objects.end(), moves)) return;
    for (const SceneObject& object : file.objects) {
      if (object.shape_word == "mesh" && !object.body) {
        report_.warnings.push_back(object.name +
                                   ": a mesh is met by fingertips only, moving objects go through it");
      }
    }
  }

  // Moments of inertia of a moving mesh, and warnings about it.
  void weigh(const CompiledMesh& mesh, const std::string& file, const std::string& name) {
    const std::optional<MeshMass> mass = mesh_mass(mesh);
    if (!mass && !object_->body->inertia_kg_m2) {
      throw Error(ExitCode::kBadInput, "no-volume",
                  name + ": the body's mesh encloses no volume, so its moments of inertia are not known",
                  "close the mesh, or give the body \"inertia_kg_m2\"");
    }
    const std::string what = object_->name + " (" + file + "): ";
    if (mass) {
      unit_inertia_ = mass->inertia_m2;
      constexpr double kOff = .02;  // of the radius of gyration
      if (mass->centre_m.norm() > kOff * std::sqrt(mass->inertia_m2.maxCoeff())) {
        report_.warnings.push_back(what + "the body turns about the mesh's origin, which is " +
                                   std::to_string(1e3 * mass->centre_m.norm()) +
                                   " mm from its centre of mass");
      }
    }
    report_.warnings.push_back(what + "a moving mesh is met by fingertips only, not by other objects");
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
  }

  flatbuffers::FlatBufferBuilder builder_;
  std::filesystem::path folder_;
  SceneReport& report_;
  std::size_t triangles_ = 0;
  const SceneObject* object_ = nullptr;                     // being written
  Eigen::Vector3d unit_inertia_ = Eigen::Vector3d::Zero();  // of its shape, for 1 kg
};

}  // namespace

CompiledScene compile_scene_text(const std::string& text, const std::string& name,
                                 const std::filesystem::path& folder) {
  const SceneFile file = read_scene_file(text, name);
  CompiledScene compiled;
  compiled.report.name = file.name;
  compiled.image = ImageWriter(folder, compiled.report).write(file, name);
  compiled.report.bytes = compiled.image.size();
  if (file.objects.empty()) {
    compiled.report.warnings.emplace_back("the scene has no object: there is nothing to touch");
  }
  return compiled;
}

CompiledScene compile_scene(const std::filesystem::path& scene_file) {
  std::error_code code;
  std::ifstream stream(scene_file, std::ios::binary);
  if (!std::filesystem::is_regular_file(scene_file, code) || !stream) {
    throw Error(ExitCode::kBadInput, "missing-scene",
                scene_file.string() + ": the scene file cannot be opened",
                "give the path of a scene file, such as scenes/asteroid/asteroid.scene.json");
  }
  const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  return compile_scene_text(text, scene_file.string(), scene_file.parent_path());
}

}  // namespace thimble::host
