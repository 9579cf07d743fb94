// DeviceSession: the running scene, its changes by pages, and its upload.
#include <exception>
#include <span>
#include <utility>

#include "firmware/link/crc32.h"
#include "host-tools/compiler/scene_errors.h"
#include "host-tools/viewer/device_session.h"

namespace thimble::host {
namespace {

// Between uploads, so that each scene swap can ramp the force down and up.
constexpr link::Micros kBetweenUploads_us = 300'000;
// The force does not ramp for other materials; a slider that moves should not wear out the store of scenes.
constexpr link::Micros kBetweenMaterials_us = 50'000;
// Between looks at the running scene's file.
constexpr link::Micros kBetweenLooks_us = 500'000;

std::uint32_t crc_of(const std::string& text) { return link::crc32(std::as_bytes(std::span(text))); }

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
  json["text_crc"] = crc_of(changed_text(*running_));
  json["unsaved"] = has_changes(*running_);
  sink_.scene(to_text(json), running_->image);
}

// --- What pages ask for

void DeviceSession::obey(const PickMessage& message) {
  picked_ = scenes_.find(message.scene);
  drop_drafts("a scene was picked before the text ran");
  edited_.reset();
  edited_since_job_ = false;
  to_upload_.reset();
  draft_is_bad_ = false;
  forget_save("another scene was picked before the change ran");
}

const OpenScene& DeviceSession::known_scene() const {
  if (!running_) {
    throw Error(ExitCode::kRefused, "no-scene-file", "the file of the scene that runs is not known here",
                "pick a scene, or give the folder of its file: `thimble view --scenes FOLDER`");
  }
  return *running_;
}

void DeviceSession::obey(const MaterialMessage& message) {
  static_cast<void>(known_scene());
  if (!edited_) edited_ = *running_;
  set_material(*edited_, message);
  edited_since_job_ = true;
}

void DeviceSession::obey(const TextMessage&) {
  if (!running_) return;  // asked before the page heard that another host has changed the scene
  const std::string text = changed_text(known_scene());
  sink_.event({{"type", "text"},
               {"file", running_->file.filename().string()},
               {"crc", crc_of(text)},
               {"unsaved", has_changes(*running_)},
               {"text", text}});
}

void DeviceSession::obey(const DraftMessage& message) {
  const std::string why = "another text of the scene came before this one ran";
  for (const std::size_t number : message.replaced) tell_of_dropped(number, why);
  if (!running_) tell_of_dropped(message.number, "the file of the scene that runs is not known here");
  static_cast<void>(known_scene());
  if (draft_) tell_of_dropped(draft_->number, why);
  draft_ = message;
  edited_.reset();  // what was changed is in the draft, or is not wanted
  edited_since_job_ = false;
}

void DeviceSession::obey(const FileMessage& message) { scenes_.put(known_scene(), message); }

void DeviceSession::obey(const SaveMessage& message) { save_wanted_ = message; }

// Saves what runs, so a pending change has to run first.
void DeviceSession::save(bool replaces) {
  if (draft_is_bad_) {
    throw Error(ExitCode::kRefused, "not-saved", "the text of the scene has errors, so nothing was saved",
                "correct the text and save again");
  }
  if (!running_ || !has_changes(*running_)) {
    inform("nothing-to-save", "nothing of the scene has been changed");
    return;
  }
  scenes_.save(*running_, replaces);
  edited_.reset();  // nothing is pending
  inform("saved", running_->file.string() + " has the changes");
  show_open_scene();
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
  if (!save_wanted_.has_value()) return;
  save_wanted_.reset();
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
    Json event = {{"type", "event"}, {"level", "error"}};
    event.update(json_of(issue));
    sink_.event(event);
  }
  if (all->more > 0)
    sink_.event(event_json("error", "more-errors", "and " + std::to_string(all->more) + " more errors",
                           "correct those above first"));
}

// The last draft has no errors.
void DeviceSession::tell_that_draft_runs(const OpenScene& scene) {
  draft_is_bad_ = false;
  sink_.event({{"type", "checked"},
               {"number", draft_number_},
               {"crc", crc_of(changed_text(scene))},
               {"issues", Json::array()},
               {"more", 0}});
}

void DeviceSession::tell_of_draft(const Error& error) {
  draft_is_bad_ = true;
  Json checked = {{"type", "checked"}, {"number", draft_number_}, {"issues", Json::array()}, {"more", 0}};
  if (const auto* const all = dynamic_cast<const SceneErrors*>(&error)) {
    for (const SceneIssue& issue : all->issues) checked["issues"].push_back(json_of(issue));
    checked["more"] = all->more;
  } else {
    checked["issues"].push_back(json_of({error.name, error.cause, error.remedy, "", {}}));
  }
  sink_.event(checked);
}

// Each draft is answered, also one that is not compiled: its page waits for it.
void DeviceSession::tell_of_dropped(std::size_t number, const std::string& why) {
  const SceneIssue issue{"draft-dropped", why, "change the text again to run it", "", {}};
  sink_.event(
      {{"type", "checked"}, {"number", number}, {"issues", Json::array({json_of(issue)})}, {"more", 0}});
}

// Those that wait, are compiled, or are to be uploaded.
void DeviceSession::drop_drafts(const std::string& why) {
  if (draft_) tell_of_dropped(draft_->number, why);
  draft_.reset();
  if (job_ == SceneJob::Kind::kDraft || (to_upload_ && to_upload_->draft))
    tell_of_dropped(draft_number_, why);
}

// Looks whether the running scene's file has changed, and runs what it has now. A draft stays: the page's user is asked which of both it is to be.
void DeviceSession::watch_file() {
  if (!running_ || job_ || picked_ || to_upload_ || edited_since_job_ || draft_ || now_us() < watch_due_us_)
    return;
  watch_due_us_ = now_us() + kBetweenLooks_us;
  if (!scenes_.has_changed(running_->file, running_->file_text)) return;
  if (running_->draft || draft_is_bad_) {
    sink_.event(event_json(
        "error", "file-changed",
        running_->file.string() + " has been changed by another program; the text edited here runs on",
        "load the scene again to have the file, or save and replace the file"));
    return;
  }
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

// The job that is done has made this.
void DeviceSession::take_done(OpenScene scene) {
  if (picked_) return;
  if (job_ == SceneJob::Kind::kReread) {
    take_reread(std::move(scene));
    return;
  }
  if (job_ == SceneJob::Kind::kDraft) {
    tell_that_draft_runs(scene);
    if (running_ && scene.crc == running_->crc) {  // a comment, say
      run_as(scene);
      show_open_scene();
      return;
    }
  }
  to_upload_ = std::move(scene);
}

void DeviceSession::take_failed(const Error& error) {
  if (picked_) return;
  if (job_ == SceneJob::Kind::kDraft) {  // the scene runs on as it was
    tell_of_draft(error);
    return;
  }
  tell(error);
  if (job_ == SceneJob::Kind::kEdited) drop_edits();
  if (job_ == SceneJob::Kind::kReread)
    inform("old-scene-runs",
           (running_ ? running_->file.string() : "the file") +
               " has changed and has errors; the scene runs as it was before",
           "correct the file");
}

void DeviceSession::begin_next_job() {
  if (!running_ && draft_) {
    tell_of_dropped(draft_->number, "another scene runs");
    draft_.reset();
  }
  if (picked_) {
    SceneJob job;
    job.scene.file = *picked_;
    picked_.reset();
    begin_job(std::move(job));
  } else if (draft_ && !to_upload_) {
    SceneJob job{SceneJob::Kind::kDraft, *running_};
    job.scene.changed_materials.clear();
    job.scene.draft.reset();
    if (draft_->text != running_->file_text) job.scene.draft = std::move(draft_->text);
    draft_number_ = draft_->number;
    draft_.reset();
    begin_job(std::move(job));
  } else if (edited_ && edited_since_job_ && !to_upload_) {
    edited_since_job_ = false;
    begin_job({SceneJob::Kind::kEdited, *edited_});
  }
}

void DeviceSession::tend_job() {
  if (job_ && scenes_.is_done()) {
    try {
      take_done(scenes_.take());
    } catch (const Error& error) {
      take_failed(error);
    } catch (const std::exception& error) {
      take_failed(Error(ExitCode::kBadInput, "failed", error.what(), "report this with the scene"));
    }
    job_.reset();
  }
  if (!job_) begin_next_job();
  watch_file();
  if (save_wanted_ && !job_ && !edited_since_job_ && !to_upload_ && !draft_) {
    const bool replaces = save_wanted_->replaces;
    save_wanted_.reset();
    try {
      save(replaces);
    } catch (const Error& error) {
      sink_.event(event_json(error));
    }
  }
}

void DeviceSession::upload(const OpenScene& scene) {
  device_->upload(*scene.image, {}, [this](const UploadProgress&) {
    if (*stopping_ || urgent_waits()) throw Disturbed{};
  });
  const bool other_file = !running_ || running_->file != scene.file;
  const bool other_objects = other_file || text_before_changes(*running_) != text_before_changes(scene);
  if (other_objects) live_.forget_scene();
  upload_due_us_ = now_us() + (other_objects ? kBetweenUploads_us : kBetweenMaterials_us);
  if (other_file) {
    edited_.reset();  // of the scene before
    edited_since_job_ = false;
  }
  told_of_other_host_ = false;
  run_as(scene);
  show_open_scene();
}

}  // namespace thimble::host
