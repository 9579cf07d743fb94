#include "host-tools/python/scene_binding.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <string>

#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/compile_help.h"
#include "host-tools/compiler/scene_errors.h"
#include "host-tools/compiler/scene_keys.h"
#include "host-tools/compiler/scene_text.h"
#include "host-tools/error.h"
#include "host-tools/files/image_file.h"
#include "host-tools/files/input_file.h"
#include "host-tools/python/binding.h"

namespace py = pybind11;

namespace thimble::host {
namespace {

py::handle error_class;  // kept for good: the interpreter may be gone before static objects are

void set_error(const Error& error, const py::list& issues) {
  PyErr_SetObject(
      error_class.ptr(),
      py::make_tuple(error.name, error.cause, error.remedy, static_cast<int>(error.code), issues).ptr());
}

py::list issues_of(const SceneErrors& errors) {
  py::list all;
  for (const SceneIssue& issue : errors.issues) {
    py::dict one;
    one["name"] = issue.name;
    one["cause"] = issue.cause;
    one["remedy"] = issue.remedy;
    one["pointer"] = issue.pointer;
    one["line"] = issue.place.line;
    all.append(one);
  }
  return all;
}

// The image of a scene file or an image file, and the CRC that the file announces, if it does.
py::tuple load(const std::filesystem::path& file) {
  ImageFile loaded;
  {
    const py::gil_scoped_release others;
    loaded = load_image(file);
  }
  return py::make_tuple(to_python(loaded.image), loaded.crc);
}

py::bytes compile_text(const std::string& text, const std::string& name,
                       const std::filesystem::path& folder) {
  std::vector<std::byte> image;
  {
    const py::gil_scoped_release others;
    image = compile_scene_text(text, name, folder).image;
  }
  return to_python(image);
}

}  // namespace

void bind_errors(py::module_& m) {
  m.def("set_error_class", [](py::object type) { error_class = type.release(); });
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const SceneErrors& errors) {
      set_error(errors, issues_of(errors));
    } catch (const Error& error) {
      set_error(error, py::list());
    }
  });
}

void bind_scene(py::module_& m) {
  set_compile_help({SolvedCache(SolvedCache::user_folder()), {}});
  m.def("load", load);
  m.def("compile_text", compile_text);
  m.def("read_text", [](const std::filesystem::path& file) { return read_input(file); });
  m.def("plain_json", without_comments);
  m.def("scene_schema", scene_schema);
  m.def("with_material", with_material);
}

}  // namespace thimble::host
