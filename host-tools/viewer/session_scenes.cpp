// DeviceSession: the running scene, its changes by pages, and its upload.
#include <chrono>
#include <exception>
#include <utility>

#include "host-tools/viewer/device_session.h"

namespace thimble::host {
namespace {

// Between uploads, so that each scene swap can ramp the force down and up.
constexpr link::Micros kBetweenUploads_us = 300'000;

}  // namespace

// --- What the pages show

// The device runs another scene than the pages show.
void DeviceSession::show_scene(const std::string& name, std::uint32_t crc) {
  shown_crc_ = crc;
  live_.forget_scene();
  if (running_ && running_->crc == crc) {
    show_open_scene();
    return;
  }
  std::optional<OpenScene> before = std::move(running_);
  running_.reset();
  edited_.reset();
  edited_since_job_ = false;
  if (!name.empty()) running_ = book_.with_crc(name, crc);
  if (running_) {
    told_of_other_host_ = false;
    show_open_scene();
    return;
  }
  // Probably another host has changed a material: keep the picture. The CRC alone does not tell the new materials.
  if (before && before->document.value("name", Json()) == Json(name) &&
      before->image->size() == device_state_.scene_bytes) {
    running_ = std::move(before);
    running_->crc = crc;
    show_open_scene();
    if (!told_of_other_host_) {
      inform("other-host",
             "another host has changed the materials of \"" + name + "\"; those shown here may be old",
             "pick the scene to have those of its file");
    }
    told_of_other_host_ = true;
    return;
  }
  sink_.scene(to_text(Json{{"type", "scene"}, {"name", name}, {"crc", crc}, {"objects", Json::array()}}),
              nullptr);
  if (!name.empty()) {
    inform("scene-unknown", "the device runs \"" + name + "\", of which no scene file is known here",
           "pick a scene, or give the folder of its file: `thimble view --scenes FOLDER`");
  }
}

void DeviceSession::show_open_scene() {
  shown_crc_ = running_->crc;
  Json json = scene_json(*running_->image, running_->crc);
  json["pick"] = name_of(running_->file);
  sink_.scene(to_text(json), running_->image);
}

// --- What pages ask for

void DeviceSession::obey(const PickMessage& message) {
  picked_ = book_.find(message.scene);
  edited_.reset();
  edited_since_job_ = false;
  to_upload_.reset();
  forget_save("another scene was picked before the change ran");
}

void DeviceSession::obey(const MaterialMessage& message) {
  if (!running_) {
    throw Error(ExitCode::kRefused, "no-scene-file", "the file of the scene that runs is not known here",
                "pick a scene, or give the folder of its file: `thimble view --scenes FOLDER`");
  }
  if (!edited_) edited_ = *running_;
  set_material(*edited_, message);
  edited_since_job_ = true;
}

void DeviceSession::obey(const SaveMessage&) { save_wanted_ = true; }

// Saves the running materials, so a pending change has to run first.
void DeviceSession::save() {
  if (!running_ || !running_->changed) {
    inform("nothing-to-save", "no material of the scene has been changed");
    return;
  }
  save_scene(*running_);
  if (edited_) edited_->file_time = running_->file_time;
  inform("saved", running_->file.string() + " has the new materials");
}

// --- Compiling and uploading

// A change could not be run.
void DeviceSession::drop_edits() {
  edited_.reset();
  edited_since_job_ = false;
  if (running_) show_open_scene();  // resets the pages too
  forget_save("the change did not come to run");
}

void DeviceSession::forget_save(const std::string& why) {
  if (!save_wanted_) return;
  save_wanted_ = false;
  sink_.event(
      event_json("error", "not-saved", "nothing was saved: " + why, "change the material and save again"));
}

// Another thread compiles, so that telemetry continues. One job at a time, because the destructor of a future of std::async waits.
void DeviceSession::tend_job() {
  if (job_ && job_->result.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    try {
      OpenScene scene = job_->result.get();
      if (!picked_) to_upload_ = std::move(scene);
    } catch (const Error& error) {
      if (!picked_) {
        sink_.event(event_json(error));
        if (!job_->picked) drop_edits();
      }
    } catch (const std::exception& error) {
      sink_.event(event_json("error", "failed", error.what(), "report this with the scene"));
      if (!job_->picked && !picked_) drop_edits();
    }
    job_.reset();
  }
  if (!job_ && picked_) {
    job_ = Job{std::async(std::launch::async, [file = *picked_] { return open_scene(file); }), true};
    picked_.reset();
  }
  if (!job_ && edited_ && edited_since_job_ && !to_upload_) {
    edited_since_job_ = false;
    job_ = Job{std::async(std::launch::async,
                          [scene = *edited_]() mutable {
                            compile_changes(scene);
                            return scene;
                          }),
               false};
  }
  if (save_wanted_ && !job_ && !edited_since_job_ && !to_upload_) {
    save_wanted_ = false;
    try {
      save();
    } catch (const Error& error) {
      sink_.event(event_json(error));
    }
  }
}

void DeviceSession::upload(const OpenScene& scene) {
  device_->upload(*scene.image, {}, [this](const UploadProgress&) {
    if (*stopping_ || urgent_waits()) throw Disturbed{};
  });
  upload_due_us_ = now_us() + kBetweenUploads_us;
  if (!running_ || running_->file != scene.file) {
    live_.forget_scene();
    edited_.reset();  // of the scene before
    edited_since_job_ = false;
  }
  told_of_other_host_ = false;
  running_ = scene;
  show_open_scene();
}

}  // namespace thimble::host
