// daemon_views.cpp: by the client library, as any reader.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/daemon_views.h"

#include <sysexits.h>

#include <algorithm>
#include <chrono>

#include "config/parameters.h"
#include "config/quoting.h"
#include "daemon/tools/calibrate/words.h"
#include "ipc/include/vdisp/client.h"
#include "ipc/include/vdisp/control.h"

namespace vdisp::calibrate {
namespace {

using Time = Client::Time;
using Clock = std::chrono::steady_clock;
constexpr Time to_connect(2500), to_first_pair(10000), to_pair(500);
constexpr const char* judged_by[] = {"image source.", "mounting.", "Limit obstacle.", "Map.", "Floor.", "main.threads"};
constexpr const char* own[] = {"image source.source", "image source.left", "image source.right", "image source.odometry",
                               "image source.loop"};

template <size_t n>
bool begins_with_one_of(const std::string& text, const char* const (&beginnings)[n]) {
  return std::any_of(std::begin(beginnings), std::end(beginnings), [&](const char* beginning) { return text.starts_with(beginning); });
}

/// As after --set: a text in quotes, or its $ and # would be taken for more than they are.
std::string assignment_of(const ParameterInfo& info) {
  const Parameter* known = find_parameter(info.key);
  const bool text = known && (known->kind == Kind::text || known->kind == Kind::path);
  return info.key + "=" + (text ? in_quotes(info.value) : info.value);
}

}  // namespace

void attach(Client& client) {
  if (client.wait_for_daemon(to_connect)) return;
  const Connection connection = client.connection();
  const int code = connection == Connection::no_permission ? EX_NOPERM
                   : connection == Connection::no_memory   ? EX_OSERR
                   : connection == Connection::wrong_name  ? EX_USAGE
                                                           : EX_UNAVAILABLE;
  throw ToolError(code, client.message());
}

cv::Mat picture_of(const Image& image) {
  return cv::Mat(image.spec.height, image.spec.width, CV_8U, const_cast<uint8_t*>(image.row<uint8_t>(0)), image.spec.stride()).clone();
}

std::vector<std::string> settings_of_daemon() {
  Control control({}, std::chrono::seconds(10));  // an answer takes a frame or two, and there are many
  std::vector<ParameterInfo> all;
  std::vector<std::string> sets;
  if (control.get_all(all) != Control::Result::done) return sets;
  for (const ParameterInfo& info : all)
    if (begins_with_one_of(info.key, judged_by) && !begins_with_one_of(info.key, own)) sets.push_back(assignment_of(info));
  return sets;
}

DaemonViews look_at_daemon(const std::string& name, int most, double seconds) {
  Client client(name);
  attach(client);
  const Client::Topic topics[] = {client.subscribe("camera/left"), client.subscribe("camera/right"), client.subscribe("left"),
                                  client.subscribe("right")};
  Reading readings[4];
  DaemonViews views;
  std::string reason;
  const Clock::time_point begin = Clock::now();
  const std::chrono::duration<double> span(seconds);
  while (static_cast<int>(views.camera.size()) < most) {
    const auto passed = Clock::now() - begin;
    const bool none = views.camera.empty();
    if (passed > (none ? std::max<std::chrono::duration<double>>(span, to_first_pair) : span)) break;
    if (!client.wait_set(topics, readings, to_pair)) continue;
    const auto fresh = std::all_of(std::begin(readings), std::end(readings), [](const Reading& r) { return r.fresh() && r.image; });
    if (!fresh) {
      ++views.blind;
      reason = describe(readings[0].reason != Reason::none ? readings[0].reason : readings[2].reason);
    } else if (passed >= span * static_cast<double>(views.camera.size()) / most) {
      views.camera.push_back({picture_of(*readings[0].image), picture_of(*readings[1].image)});
      views.rectified.push_back({picture_of(*readings[2].image), picture_of(*readings[3].image)});
      const CameraGeometry& camera = readings[2].image->camera;
      views.view = {camera.f, camera.cx, camera.cy, camera.baseline, camera.cx_offset};
      views.calibration_hash = readings[2].image->calibration_hash;
    }
    for (Client::Topic topic : topics) client.release(topic);
  }
  if (views.camera.empty())
    throw ToolError(EX_UNAVAILABLE, "no good pair from the daemon within " + std::to_string(static_cast<int>(std::max(seconds, 10.0))) +
                                        " s" +
                                        (!reason.empty()            ? ", it is blind: " + reason
                                         : client.message().empty() ? "; vdisp-probe stats tells what it does"
                                                                    : "; " + client.message()));
  return views;
}

}  // namespace vdisp::calibrate
