// dump.cpp: one FrameDump after the other.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/dump.h"

#include <sysexits.h>

#include <fstream>

namespace vdisp {
namespace fs = std::filesystem;

Dump::Dump(fs::path folder, bool images) : folder_(std::move(folder)), images_(images) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw WriteError(EX_CANTCREAT, folder_.string() + ": cannot be created: " + error.message());
  if (fs::exists(folder_ / frame_name(0)))
    throw WriteError(EX_CANTCREAT, folder_.string() + ": holds the frames of another run already; name an empty folder");
}

void Dump::see(const Topic& topic, const Image& image) noexcept {
  if (failed_) return;
  try {
    if (!current_) current_.emplace(folder_ / frame_name(frame_));
    current_->add(topic.name, image);
    if (images_) current_->add_file(topic.name + ".image", {reinterpret_cast<const char*>(&image), image.spec.bytes()});
  } catch (const WriteError& error) {
    failed_ = error;
  } catch (const std::exception& error) {
    failed_.emplace(EX_IOERR, folder_.string() + ": " + error.what());
  }
}

void Dump::finish_frame(const Driver& driver, const std::pair<std::string, std::string>& files) {
  if (failed_) {
    current_.reset();
    throw WriteError(*failed_);
  }
  if (!current_) return;
  for (size_t i = 0; i < driver.topics().size(); ++i)
    current_->add_timing(driver.topics()[i].name, driver.timing({static_cast<int>(i)}).last_ns);
  current_->finish(fs::path(files.first).filename(), fs::path(files.second).filename());
  current_.reset();
  ++frame_;
}

void write_graph(const Driver& driver, const std::string& name) {
  std::ofstream file(name);
  driver.write_dot(file);
  if (!file.flush()) throw WriteError(EX_CANTCREAT, name + ": the tree cannot be written there");
}

}  // namespace vdisp
