// DeviceSession: the running scene, its changes by pages, and its upload.
#include <exception>
#include <utility>

#include "host-tools/compiler/scene_errors.h"
#include "host-tools/viewer/device_session.h"

namespace thimble::host {
namespace {

// Between uploads, so that each scene swap can ramp the force down and up.
constexpr link::Micros kBetweenUploads_us = 300'000;
// Between looks at the running scene's file.
constexpr link::Micros kBetweenLooks_us = 500'000;

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
  if (!name.empty()) running_ = scenes_.with_crc(name, crc);
  if (running_) {
    told_of_other_host_ = false;
    show_open_scene();
    return;
  }
  // Probably another host has changed a material: keep the picture. The CRC alone does not tell the new materials.
  if (before && before->name == name && before->image->size() == device_state_.scene_bytes) {
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
  picked_ = scenes_.find(message.scene);
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
  if (!running_ || running_->changed_materials.empty()) {
    inform("nothing-to-save", "no material of the scene has been changed");
    return;
  }
  scenes_.save(*running_);
  edited_.reset();  // nothing is pending
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

// What is wrong with a scene: an event for each error.
void DeviceSession::tell(const Error& error) {
  const auto* const all = dynamic_cast<const SceneErrors*>(&error);
  if (all == nullptr) {
    sink_.event(event_json(error));
    return;
  }
  for (const SceneIssue& issue : all->issues) {
    Json event = event_json("error", issue.name, issue.cause, issue.remedy);
    event["pointer"] = issue.pointer;
    event["line"] = issue.place.line;
    event["column"] = issue.place.column;
    sink_.event(event);
  }
  if (all->more > 0)
    sink_.event(event_json("error", "more-errors", "and " + std::to_string(all->more) + " more errors",
                           "correct those above first"));
}

// Looks whether the running scene's file has changed, and runs what it has now.
void DeviceSession::watch_file() {
  if (!running_ || job_ || picked_ || to_upload_ || edited_since_job_ || now_us() < watch_due_us_) return;
  watch_due_us_ = now_us() + kBetweenLooks_us;
  if (!scenes_.has_changed(running_->file, running_->file_text)) return;
  begin_job({SceneJob::Kind::kReread, edited_ ? *edited_ : *running_});
}

// The file of the running scene has been read again.
void DeviceSession::take_reread(OpenScene scene) {
  if (scene.crc == running_->crc) {  // a comment, say
    run_as(scene);
    return;
  }
  const std::size_t changes = scene.changed_materials.size();
  inform("scene-reloaded",
         scene.file.string() + " has changed, and runs as it is now" +
             (changes == 0 ? "" : "; what was changed here and is not saved stays changed"));
  to_upload_ = std::move(scene);
}

// Changes that came since it was compiled, from another text of the file perhaps, are of this text now.
void DeviceSession::run_as(const OpenScene& scene) {
  running_ = scene;
  if (!edited_) return;
  const OpenScene before = std::exchange(*edited_, scene);
  carry_changes(before, *edited_);
}

void DeviceSession::begin_job(SceneJob job) {
  job_ = job.kind;
  scenes_.begin(std::move(job));
}

void DeviceSession::tend_job() {
  if (job_ && scenes_.is_done()) {
    try {
      OpenScene scene = scenes_.take();
      if (!picked_ && job_ == SceneJob::Kind::kReread)
        take_reread(std::move(scene));
      else if (!picked_)
        to_upload_ = std::move(scene);
    } catch (const Error& error) {
      if (!picked_) {
        tell(error);
        if (job_ == SceneJob::Kind::kEdited) drop_edits();
        if (job_ == SceneJob::Kind::kReread)
          inform("old-scene-runs",
                 (running_ ? running_->file.string() : "the file") +
                     " has changed and has errors; the scene runs as it was before",
                 "correct the file");
      }
    } catch (const std::exception& error) {
      sink_.event(event_json("error", "failed", error.what(), "report this with the scene"));
      if (job_ == SceneJob::Kind::kEdited && !picked_) drop_edits();
    }
    job_.reset();
  }
  if (!job_ && picked_) {
    SceneJob job;
    job.scene.file = *picked_;
    picked_.reset();
    begin_job(std::move(job));
  }
  if (!job_ && edited_ && edited_since_job_ && !to_upload_) {
    edited_since_job_ = false;
    begin_job({SceneJob::Kind::kEdited, *edited_});
  }
  watch_file();
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
  run_as(scene);
  show_open_scene();
}

}  // namespace thimble::host
