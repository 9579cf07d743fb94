#include "tests/support/scene.h"

#include <stdexcept>

#include "control/scene/mesh_triangle.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {

namespace {

scene::Vec3 vec3(const Eigen::Vector3d& v) {
  const Eigen::Vector3f f = v.cast<float>();
  return {f.x(), f.y(), f.z()};
}

}  // namespace

SceneImage::SceneImage(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {
  const control::ImageStatus status = control::SceneView::check(bytes_, view_);
  if (status != control::ImageStatus::kOk) {
    throw std::runtime_error(std::string("the scene image was refused: ") + control::name(status));
  }
}

struct SceneBuilder::State {
  flatbuffers::FlatBufferBuilder builder;
  std::vector<flatbuffers::Offset<scene::Object>> objects;
  float tip_radius_m = 0.0F;

  void add(scene::Shape kind, flatbuffers::Offset<void> shape, const Material& m, const Pose& pose) {
    const auto name = builder.CreateString("object " + std::to_string(objects.size()));
    const Eigen::Quaternionf q = pose.rotation.normalized().cast<float>().normalized();
    const scene::Pose place(vec3(pose.position_m), scene::Quat(q.w(), q.x(), q.y(), q.z()));
    const scene::Material material(m.stiffness_N_m, m.damping_N_s_m, m.static_friction, m.dynamic_friction,
                                   m.friction_mode);
    objects.push_back(scene::CreateObject(builder, name, kind, shape, &place, &material));
  }
};

SceneBuilder::SceneBuilder() : state_(std::make_unique<State>()) {}
SceneBuilder::~SceneBuilder() = default;

SceneBuilder& SceneBuilder::plane(const Eigen::Vector3d& normal, double offset_m, const Material& material,
                                  const Pose& pose) {
  const scene::Plane shape(vec3(normal.normalized()), static_cast<float>(offset_m));
  state_->add(scene::Shape::Plane, state_->builder.CreateStruct(shape).Union(), material, pose);
  return *this;
}

SceneBuilder& SceneBuilder::sphere(double radius_m, const Material& material, const Pose& pose) {
  const scene::Sphere shape(static_cast<float>(radius_m));
  state_->add(scene::Shape::Sphere, state_->builder.CreateStruct(shape).Union(), material, pose);
  return *this;
}

SceneBuilder& SceneBuilder::box(const Eigen::Vector3d& size_m, const Material& material, const Pose& pose) {
  const scene::Box shape(vec3(0.5 * size_m));
  state_->add(scene::Shape::Box, state_->builder.CreateStruct(shape).Union(), material, pose);
  return *this;
}

SceneBuilder& SceneBuilder::cylinder(double radius_m, double half_height_m, const Material& material,
                                     const Pose& pose) {
  const scene::Cylinder shape(static_cast<float>(radius_m), static_cast<float>(half_height_m));
  state_->add(scene::Shape::Cylinder, state_->builder.CreateStruct(shape).Union(), material, pose);
  return *this;
}

SceneBuilder& SceneBuilder::capsule(double radius_m, double half_height_m, const Material& material,
                                    const Pose& pose) {
  const scene::Capsule shape(static_cast<float>(radius_m), static_cast<float>(half_height_m));
  state_->add(scene::Shape::Capsule, state_->builder.CreateStruct(shape).Union(), material, pose);
  return *this;
}

SceneBuilder& SceneBuilder::cone(double radius_m, double height_m, const Material& material,
                                 const Pose& pose) {
  const scene::Cone shape(static_cast<float>(radius_m), static_cast<float>(height_m));
  state_->add(scene::Shape::Cone, state_->builder.CreateStruct(shape).Union(), material, pose);
  return *this;
}

SceneBuilder& SceneBuilder::mesh(const host::CompiledMesh& mesh, const Material& material, const Pose& pose) {
  flatbuffers::FlatBufferBuilder& builder = state_->builder;
  const auto vertices = builder.CreateVectorOfStructs(mesh.vertices);
  const auto triangles = builder.CreateVectorOfStructs(mesh.triangles);
  const auto flags = builder.CreateVector(mesh.flags);
  const auto nodes = builder.CreateVectorOfStructs(mesh.nodes);
  flatbuffers::Offset<flatbuffers::Vector<std::uint32_t>> normals = 0;
  if (!mesh.corner_normals.empty()) normals = builder.CreateVector(mesh.corner_normals);
  const auto rims = mesh.rims.empty() ? 0 : builder.CreateVector(mesh.rims);
  scene::MeshBuilder table(builder);
  table.add_vertices(vertices);
  table.add_triangles(triangles);
  table.add_flags(flags);
  if (!normals.IsNull()) table.add_corner_normals(normals);
  table.add_nodes(nodes);
  table.add_grid_origin_m(&mesh.grid_origin_m);
  table.add_grid_step_m(mesh.grid_step_m);
  table.add_depth(mesh.depth);
  table.add_seams(mesh.seams);
  if (!mesh.rims.empty()) table.add_rims(rims);
  state_->add(scene::Shape::Mesh, table.Finish().Union(), material, pose);
  return *this;
}

SceneBuilder& SceneBuilder::mesh(const host::TriangleSoup& soup, const Material& material,
                                 const host::MeshOptions& options, const Pose& pose) {
  return mesh(host::compile_mesh(soup, options, "test mesh"), material, pose);
}

SceneBuilder& SceneBuilder::tip_radius(double radius_m) {
  state_->tip_radius_m = static_cast<float>(radius_m);
  return *this;
}

std::vector<std::byte> SceneBuilder::bytes() {
  flatbuffers::FlatBufferBuilder& builder = state_->builder;
  const auto name = builder.CreateString("test scene");
  const auto objects = builder.CreateVector(state_->objects);
  scene::FinishSceneBuffer(builder,
                           scene::CreateScene(builder, name, objects, nullptr, state_->tip_radius_m));
  const std::span<const std::byte> finished =
      std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
  return {finished.begin(), finished.end()};
}

host::TriangleSoup as_soup(const host::CompiledMesh& mesh) {
  host::TriangleSoup soup;
  for (const scene::Vertex& vertex : mesh.vertices) {
    const scene::Vec3& p = vertex.position_m();
    soup.vertices_m.push_back(Eigen::Vector3f(p.x(), p.y(), p.z()).cast<double>());
  }
  for (const scene::Triangle& triangle : mesh.triangles) {
    soup.triangles.push_back(
        {control::vertex_of(triangle, 0), control::vertex_of(triangle, 1), control::vertex_of(triangle, 2)});
  }
  return soup;
}

}  // namespace thimble::test
