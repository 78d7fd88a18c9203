// aravis.cpp: one camera of GenICam's world: found, opened, its buffers, and how it is noticed that it is gone.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/aravis.h"

#include <arv.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>

#include "daemon/core/clock.h"
#include "daemon/sources/aravis_list.h"
#include "daemon/sources/aravis_setup.h"
#include "daemon/sources/frame_count.h"
#include "daemon/sources/live.h"

namespace vdisp {
namespace {

constexpr int buffers = 8;  // a quarter of a second at 30 Hz: none is lost while the thread waits for a processor
constexpr int64_t exposure_read_ns = 1'000'000'000;
constexpr int tries_a_search = 4;  // most of the time a camera comes back where it was

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
template <class T>
using Owned = std::unique_ptr<T, Unref>;

class AravisCamera final : public Camera {
 public:
  AravisCamera(CameraWish wish, const Config& config)
      : config_(config), wish_(std::move(wish)), name_(std::string(wish_.side == 0 ? "left" : "right") + " camera " + wish_.name) {}
  ~AravisCamera() override { close(); }

  const std::string& name() const override { return name_; }
  FrameFormat open() override;
  Delivery wait(int timeout_ms, RawFrame& frame) noexcept override;
  void release(const RawFrame&) noexcept override { give_back(); }
  void close() noexcept override;
  std::string_view problem() const noexcept override { return problem_; }
  void trigger() noexcept override;
  bool expose(double exposure_us, double gain_db) noexcept override;
  double longest_exposure() const noexcept override { return longest_us_; }
  double highest_gain() const noexcept override { return highest_gain_; }

 private:
  void connect();
  void begin_stream();
  void read_exposure() noexcept;
  bool understand(RawFrame& frame) noexcept;
  const char* describe(ArvBufferStatus status) const noexcept;
  void give_back() noexcept {
    if (buffer_) arv_stream_push_buffer(stream_.get(), buffer_.release());
  }

  const Config& config_;
  const CameraWish wish_;
  std::optional<AttachedCamera> known_;  // once opened: this one and no other
  std::string name_;
  FrameFormat format_;
  std::mutex features_;  // Aravis' description of the camera is not for two threads: trigger() and expose()
  Owned<ArvCamera> camera_;
  Owned<ArvStream> stream_;
  Owned<ArvBuffer> buffer_;
  FrameCount count_;
  std::atomic<bool> control_lost_{false};
  double shorter_us_ = 0;  // before it grew, for frames that were on their way
  int settling_ = 0;       // so many
  double exposure_us_ = 0, longest_us_ = 0, highest_gain_ = 0;
  int64_t exposure_read_ns_ = 0;
  int tries_ = 1;
  const char* problem_ = "";
};

FrameFormat AravisCamera::open() {
  prepare_aravis();
  const std::lock_guard lock(features_);
  try {
    connect();
    format_ = set_up(camera_.get(), config_, name_);
    begin_stream();
  } catch (...) {
    close();
    throw;
  }
  return format_;
}

void AravisCamera::connect() {
  const bool everywhere = tries_++ % tries_a_search == 0;
  const AttachedCamera found = known_ ? find_again(*known_, everywhere) : choose(wish_, attached_aravis_cameras());
  const std::string named = (found.gige ? "GigE camera " : "USB3 camera ") + found.id;
  AravisError error;
  camera_.reset(arv_camera_new(found.address.empty() ? found.id.c_str() : found.address.c_str(), error));
  error.check(named, "opened");
  if (!camera_) throw CameraError(CameraFault::failed, named + " does not open");
  ArvDevice* device = arv_camera_get_device(camera_.get());
  if (ARV_IS_GV_DEVICE(device) && !arv_gv_device_is_controller(ARV_GV_DEVICE(device)))
    throw CameraError(CameraFault::busy, named + " is in use: another program controls it; end that, or wait 3 s after it died");
  control_lost_ = false;
  g_signal_connect(device, "control-lost", G_CALLBACK(+[](ArvDevice*, void* lost) { *static_cast<std::atomic<bool>*>(lost) = true; }),
                   &control_lost_);
  if (!known_) name_ = named;
  known_ = found;
  tries_ = 1;
}

void AravisCamera::begin_stream() {
  AravisError error;
  double least = 0;
  longest_us_ = highest_gain_ = 0;
  if (arv_camera_is_exposure_time_available(camera_.get(), nullptr))
    arv_camera_get_exposure_time_bounds(camera_.get(), &least, &longest_us_, nullptr);
  if (arv_camera_is_gain_available(camera_.get(), nullptr)) arv_camera_get_gain_bounds(camera_.get(), &least, &highest_gain_, nullptr);
  exposure_us_ = 0;
  settling_ = 0;
  read_exposure();
  stream_.reset(arv_camera_create_stream(camera_.get(), nullptr, nullptr, error));
  error.check(name_, "asked for a stream");
  if (!stream_) throw CameraError(CameraFault::failed, name_ + " gives no stream");
  const guint payload = arv_camera_get_payload(camera_.get(), error);
  error.check(name_, "asked for the size of its frames");
  for (int i = 0; i < buffers; ++i) arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(payload));
  count_.reset();
  arv_camera_start_acquisition(camera_.get(), error);
  error.check(name_, "started");
}

void AravisCamera::read_exposure() noexcept {
  exposure_read_ns_ = monotonic_ns();
  const double now = arv_camera_get_exposure_time(camera_.get(), nullptr);
  if (now <= 0) return;
  if (exposure_us_ > 0 && now > exposure_us_) {
    shorter_us_ = settling_ > 0 ? std::min(shorter_us_, exposure_us_) : exposure_us_;
    settling_ = buffers;
  }
  exposure_us_ = now;
}

void AravisCamera::close() noexcept {
  give_back();
  if (camera_) {
    // A camera that is gone would be asked for seconds.
    if (stream_ && !control_lost_) arv_camera_stop_acquisition(camera_.get(), nullptr);
    g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera_.get()), &control_lost_);
  }
  stream_.reset();
  camera_.reset();
}

const char* AravisCamera::describe(ArvBufferStatus status) const noexcept {
  switch (status) {
    case ARV_BUFFER_STATUS_TIMEOUT:
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return known_->gige ? "frames come incomplete: packets are lost on the way (docs/cameras.md: packetSize, net.core.rmem_max, cable)"
                          : "frames come incomplete: the USB does not carry them (docs/cameras.md: usbfs_memory_mb, rate, cable)";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH: return "frames are larger than the camera said";
    default: return "frames come unfinished";
  }
}

/// False: no picture, or one of another shape than was agreed.
bool AravisCamera::understand(RawFrame& frame) noexcept {
  ArvBuffer* buffer = buffer_.get();
  const ArvBufferPayloadType type = arv_buffer_get_payload_type(buffer);
  if (type != ARV_BUFFER_PAYLOAD_TYPE_IMAGE && type != ARV_BUFFER_PAYLOAD_TYPE_EXTENDED_CHUNK_DATA) {
    problem_ = "sends something that is no image";
    return false;
  }
  gint x = 0, y = 0, width = 0, height = 0, pad_x = 0, pad_y = 0;
  arv_buffer_get_image_region(buffer, &x, &y, &width, &height);
  arv_buffer_get_image_padding(buffer, &pad_x, &pad_y);
  if (width != format_.width * (format_.views == FrameViews::one ? 1 : 2) || height != format_.height || pad_x != 0) {
    problem_ = "frames have another size than the camera said";
    return false;
  }
  size_t size = 0;
  frame.bytes = static_cast<const std::byte*>(arv_buffer_get_image_data(buffer, &size));
  frame.size = size;
  frame.arrival_ns = monotonic_ns();
  // GenICam SFNC, Timestamp: when the exposure began (FrameStart). Exposure ends before the frame can arrive.
  // Frames on their way when it grew were exposed as before: taken for longer ones they would set the clock back for seconds.
  const double sure = settling_ > 0 ? std::min(shorter_us_, exposure_us_) : exposure_us_;
  if (settling_ > 0) --settling_;
  const auto half = static_cast<int64_t>(exposure_us_ * 500);
  const auto began = static_cast<int64_t>(arv_buffer_get_timestamp(buffer));
  frame.camera_ns = began > 0 ? began + half : -1;
  frame.delay_ns = began > 0 ? static_cast<int64_t>(sure * 1000) - half : half;
  frame.count = count_.of(arv_buffer_get_frame_id(buffer));
  return true;
}

Delivery AravisCamera::wait(int timeout_ms, RawFrame& frame) noexcept {
  give_back();
  buffer_.reset(arv_stream_timeout_pop_buffer(stream_.get(), static_cast<guint64>(timeout_ms) * 1000));
  if (control_lost_) {
    problem_ = "does not answer any more, or has another master; it is opened again";
    return Delivery::lost;
  }
  if (!buffer_) return Delivery::nothing;
  const ArvBufferStatus status = arv_buffer_get_status(buffer_.get());
  if (status == ARV_BUFFER_STATUS_CLEARED || status == ARV_BUFFER_STATUS_ABORTED) return Delivery::nothing;
  if (status != ARV_BUFFER_STATUS_SUCCESS) {
    problem_ = describe(status);
    return Delivery::incomplete;
  }
  if (!understand(frame)) return Delivery::incomplete;
  // Only right after a frame: it is there, and answers at once.
  if (config_.camera.exposeBy == "camera" && exposure_us_ > 0 && frame.arrival_ns - exposure_read_ns_ > exposure_read_ns) {
    const std::unique_lock lock(features_, std::try_to_lock);
    if (lock) read_exposure();
  }
  return Delivery::frame;
}

void AravisCamera::trigger() noexcept {
  const std::lock_guard lock(features_);
  if (camera_ && stream_ && !control_lost_) arv_camera_software_trigger(camera_.get(), nullptr);
}

bool AravisCamera::expose(double exposure_us, double gain_db) noexcept {
  const std::lock_guard lock(features_);
  if (!camera_ || longest_us_ <= 0) return false;
  AravisError error;
  double least = 0, most = 0;
  arv_camera_get_exposure_time_bounds(camera_.get(), &least, &most, error);
  arv_camera_set_exposure_time(camera_.get(), std::clamp(exposure_us, least, std::max(least, most)), error);
  if (error.happened()) return false;
  read_exposure();
  if (highest_gain_ > 0) arv_camera_set_gain(camera_.get(), std::min(gain_db, highest_gain_), error);
  return !error.happened();
}

}  // namespace

std::vector<std::unique_ptr<Camera>> aravis_cameras(const Config& config) {
  const int sides = config.camera.views == "one" ? 2 : 1;
  const std::string names[] = {config.camera.left, sides == 2 ? config.camera.right : ""};
  std::vector<std::unique_ptr<Camera>> cameras;
  for (int side = 0; side < sides; ++side)
    cameras.push_back(std::make_unique<AravisCamera>(CameraWish{names[side], names[1 - side], side, sides}, config));
  return cameras;
}

std::unique_ptr<StereoSource> open_aravis(const Config& config) { return open_live(config, aravis_cameras(config)); }

std::vector<std::string> attached_to_aravis() {
  std::vector<std::string> names;
  for (const AttachedCamera& camera : attached_aravis_cameras()) names.push_back(camera.words());
  return names;
}

}  // namespace vdisp
