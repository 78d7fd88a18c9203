// image_fuzz.cpp: any bytes as an image in shared memory: refused, or read by the client library and the probe within its bytes.
// SPDX-License-Identifier: Apache-2.0
//
// The first bytes say what is put right, so that not all is refused for its magic; then come header and rows. The block ends where the size
// that iceoryx tells ends: the address checker sees who reads on.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "daemon/tools/drive/orders.h"
#include "ipc/dump.h"
#include "ipc/dump_json.h"
#include "ipc/examples/followed_map.h"
#include "ipc/include/vdisp/client_c.h"
#include "ipc/received.h"
#include "ipc/recording_text.h"
#include "ipc/step_taker.h"
#include "probe/health.h"
#include "probe/kept.h"
#include "probe/map_text.h"
#include "probe/paint.h"
#include "probe/readout.h"
#include "probe/tree.h"
#include "tests/fuzz/require.h"

namespace vdisp {
namespace {

constexpr int64_t now_ns = 1'000'000'000'000;
constexpr size_t largest = 1 << 18;   // bytes of a block: enough for every record, and quick
constexpr int most_pixels = 1 << 12;  // that are painted

constexpr const char* topics[] = {"disparity",   "map",     "occupancy", "reason",    "fused_reason", "surface",     "features",
                                  "census/left", "left",    "map_cells", "depth_map", "vdisparity",   "camera/left", "truth/steering",
                                  "drive",       "in/event"};

struct Record {
  RecordType type;
  uint16_t version;
  ImageSpec spec;
};
template <class... Records>
constexpr auto table() {
  return std::array{Record{Records::type, Records::version, record_spec<Records>()}...};
}
constexpr auto records =
    table<FloorModel, Catalogue, Heartbeat, TruthScene, Odometry, Imu, DriveOrder, Events, MapChanges, Memory, Tracks, CameraStatus,
          SnowScores, Decision, DriveCommand, CrossCheck, CalibrationWatch, Health, RecorderStatus, CalibrationText>();

struct Free {
  void operator()(std::byte* memory) const { std::free(memory); }
};
using Block = std::unique_ptr<std::byte[], Free>;

enum Repair : uint8_t { magic = 1, size = 2, record = 4, valid = 8, recent = 16, small = 32 };

/// Which header is told in `how`; the rest of the block is filled with what is left, again and again.
Block block_of(Bytes bytes, uint8_t how, uint64_t& length) {
  alignas(Image) std::array<std::byte, sizeof(Image)> header{};
  const auto which = bytes.number<uint8_t>();
  const auto beyond = bytes.number<int8_t>();
  bytes.copy(header.data(), header.size());
  Image& image = *reinterpret_cast<Image*>(header.data());
  if (how & magic) image.magic = Image::magic_value, image.version = Image::version_value;
  if (how & small) image.spec.width %= 200, image.spec.height %= 120;
  if (how & record) image.spec = records[which % records.size()].spec;
  if (how & valid) image.state = ImageState::valid, image.reason = Reason::none;
  if (how & recent) image.ready_ns = now_ns - image.ready_ns % 1'000'000'000, image.epoch = 7;
  const uint64_t told = sizeof(Image) + static_cast<uint64_t>(image.spec.stride()) * image.spec.height;
  length = how & size ? told + static_cast<uint64_t>(static_cast<int64_t>(beyond)) : header.size() + bytes.size();
  length = std::min<uint64_t>(length, largest);
  void* memory = nullptr;
  if (posix_memalign(&memory, alignof(Image), std::max<size_t>(length, 1)) != 0) std::abort();
  Block block(static_cast<std::byte*>(memory));
  std::memset(memory, 0, length);
  std::memcpy(memory, header.data(), std::min<size_t>(header.size(), length));
  if (length <= header.size()) return block;
  std::byte* rows = block.get() + header.size();
  const size_t given = std::min<size_t>(bytes.size(), length - header.size());
  bytes.copy(rows, given);
  for (size_t i = given; given > 0 && i < length - header.size(); ++i) rows[i] = rows[i - given];
  if ((how & record) && length >= header.size() + sizeof(RecordHeader)) {
    const Record& wanted = records[which % records.size()];
    const RecordHeader right{wanted.type, wanted.version, wanted.spec.width};
    std::memcpy(rows, &right, sizeof right);
  }
  return block;
}

uint64_t sum(const void* row, size_t size) {
  const auto* bytes = static_cast<const uint8_t*>(row);
  uint64_t total = 0;
  for (size_t i = 0; i < size; ++i) total += bytes[i];
  return total;
}

/// All that the header promises is there.
void read_all(const Image& image) {
  const auto* handle = reinterpret_cast<const vdisp_image*>(&image);
  const vdisp_image_info info = vdisp_describe(handle);
  const size_t row_bytes = static_cast<size_t>(image.spec.width) * pixel_bytes(image.spec.pixel);
  uint64_t total = 0;
  for (int y = 0; y < info.height; ++y) {
    const void* row = vdisp_row(handle, y);
    require(row == image.row<uint8_t>(y), "C and C++ tell the same row");
    total += sum(row, row_bytes);
  }
  require(!vdisp_row(handle, -1) && !vdisp_row(handle, info.height), "no row outside the image");
  require(info.stride >= row_bytes && info.stride % 64 == 0, "rows do not overlap");
  require(vdisp_reason(info.reason) != nullptr && total + 1 > 0, "a reason has words");
  KeptImage kept;
  kept.keep(image);
  require(kept.get()->spec == image.spec, "a copy is the same");
}

void judge(const Image& image, Bytes& bytes) {
  const Beat beat{bytes.number<uint8_t>() & 7u, now_ns - bytes.number<int32_t>(),
                  std::clamp<int64_t>(bytes.number<int32_t>(), 0, INT32_MAX)};
  const Reading reading = judged(&image, beat, now_ns);
  if (reading.fresh()) {
    require(image.valid() && beat.epoch != 0 && image.epoch == beat.epoch, "what is fresh is valid, and of this daemon");
    require(std::abs(reading.age_s) <= 3 * static_cast<double>(INT32_MAX) * 1e-9, "what is fresh is of now");
  }
  const drive::Order order = drive::judge(reading, 0.3, false, now_ns);
  if (order.halt == drive::Halt::none)
    require(std::isfinite(order.speed) && std::isfinite(order.turn_rate) && !(image.flags & flag_synthetic), "an order is one");
}

void tell_json(const Image& image) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  const auto add = [&]<class R>(const R* found, auto json) {
    if (found) all.push_back(json(*found));
  };
  if (image.spec == record_spec<FloorModel>()) all.push_back(floor_json(image));
  all.push_back(input_json(image));
  add(record_of<TruthScene>(image), scene_json);
  add(record_of<MapChanges>(image), changes_json);
  add(record_of<Memory>(image), memory_json);
  add(record_of<Tracks>(image), tracks_json);
  add(record_of<SnowScores>(image), scores_json);
  add(record_of<Decision>(image), decision_json);
  add(record_of<DriveCommand>(image), command_json);
  add(record_of<CrossCheck>(image), check_json);
  add(record_of<CalibrationWatch>(image), watch_json);
  add(record_of<CameraStatus>(image), cameras_json);
  add(record_of<Health>(image), health_json);
  require(!all.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).empty(), "a record is JSON");
}

void read_record(const Image& image) {
  for (const std::string& line : record_text(image)) require(line.size() < 4096, "a record is some words a line");
  tell_json(image);
  if (const Catalogue* catalogue = record_of<Catalogue>(image)) {
    const std::vector<CatalogueEntry> entries = entries_of(*catalogue);
    require(tree_of(entries, true).size() == entries.size(), "each entry stands in the tree once");
    for (const CatalogueEntry& entry : entries) {
      require(std::string_view(entry.name).size() < sizeof entry.name, "a name ends");
      require(!spec_words(entry.spec).empty(), "a spec has words");
    }
  }
  if (const Health* health = record_of<Health>(image)) {
    require(!health_words(*health).empty(), "health has words");
    const LatencyHistogram since = health->latency.since({});
    require(latency_words(since).size() < 256, "latency has words");
  }
  StepTaker taker({Pixel::gray8, 0, 16, 8});
  TakenStep taken({Pixel::gray8, 0, 16, 8});
  taker.begin(taken);
  for (const char* topic : topics) taker.see(topic, image);
  if (taker.finish()) require(!recording::step_line(taken.step, true).empty(), "a step is a line");
}

/// As the window and the files of the probe show it.
void paint_picture(std::string_view topic, const Image& image) {
  if (static_cast<int64_t>(image.spec.width) * image.spec.height > most_pixels) return;
  const PaintStyle style{Palette::turbo, 90, 70, 0};
  if (image.valid()) require(paint(topic, image, style).cell > 0, "a cell has a size");
  if (image.spec.width * image.spec.height <= 256) portrait(topic, image, style);
  legend(topic, image, style);
  for (const int column : {0, image.spec.width - 1, static_cast<int>(image.spec.width)})
    for (const int row : {0, image.spec.height - 1, static_cast<int>(image.spec.height)}) read_out(topic, image, column, row);
  if (!image.valid()) return;
  if (image.spec.pixel == Pixel::count16) {
    map_text(image, {});
    map_text(image, {70, 20, true, true, false});
    nearest_words(image);
  }
  if (image.spec.pixel == Pixel::disparity16) rejected_json(image);
  camera_json(image.camera);
  grid_json(image.grid);
}

void try_block(std::string_view topic, const Block& block, uint64_t length, Bytes bytes) {
  const Image* image = image_in(block.get(), length);
  if (!image) return;
  read_all(*image);
  judge(*image, bytes);
  if (image->spec.pixel == Pixel::record) return read_record(*image);
  paint_picture(topic, *image);
  const ImageSpec camera{Pixel::gray8, 0, 64, 48};
  StepTaker taker(camera);
  TakenStep taken(camera);
  taker.begin(taken);
  taker.see(topic, *image);
}

/// A list of changes beside a grid, which need not fit each other.
void follow(Bytes bytes) {
  uint64_t grid_length = 0, list_length = 0;
  const auto cells = bytes.text(bytes.number<uint8_t>());
  const Block grid_block =
      block_of({reinterpret_cast<const uint8_t*>(cells.data()), cells.size()}, magic | size | valid | recent | small, grid_length);
  const Block list_block = block_of(bytes, magic | size | record | valid | recent, list_length);
  if (grid_length < sizeof(Image)) return;
  auto* grid = reinterpret_cast<Image*>(grid_block.get());
  const Image* list = image_in(list_block.get(), list_length);
  grid->spec.pixel = Pixel::int8;
  if (list) grid->sequence = list->sequence, grid->epoch = list->epoch;
  const Image* image = image_in(grid, grid_length);
  if (!image || !list || image->spec.width * image->spec.height > 2000) return;
  planner::FollowedMap map({});
  for (int frame = 0; frame < 2; ++frame) map.follow(image, list);
  if (map.known()) require(map.rows() == image->spec.height && map.columns() == image->spec.width, "the copy has the grid's size");
}

}  // namespace
}  // namespace vdisp

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace vdisp;
  if (size < 4 || size > 65536) return 0;
  Bytes bytes(data, size);
  const auto how = bytes.number<uint8_t>();
  const std::string_view topic = topics[bytes.number<uint8_t>() % std::size(topics)];
  if (how & 128) {
    follow(bytes);
    return 0;
  }
  uint64_t length = 0;
  const Block block = block_of(bytes, how, length);
  try_block(topic, block, length, bytes);
  return 0;
}
