// client_c.cpp: the client library for C, in terms of the one for C++.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/include/vdisp/client_c.h"

#include <new>

#include "ipc/include/vdisp/client.h"

struct vdisp_client {
  vdisp::Client client;
};

namespace {

const vdisp::Image* image_of(const vdisp_image* image) { return reinterpret_cast<const vdisp::Image*>(image); }

vdisp_reading reading_of(const vdisp::Reading& reading) {
  return {reinterpret_cast<const vdisp_image*>(reading.image), static_cast<vdisp_trust>(reading.trust),
          static_cast<uint32_t>(reading.reason), reading.age_s};
}

}  // namespace

vdisp_client* vdisp_open(const char* instance) {
  try {
    return instance ? new vdisp_client{vdisp::Client(instance)} : new vdisp_client{vdisp::Client()};
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void vdisp_close(vdisp_client* client) { delete client; }

vdisp_connection vdisp_connect(vdisp_client* client, int limit_ms) {
  if (client->client.wait_for_daemon(vdisp::Client::Time(limit_ms))) return VDISP_CONNECTED;
  return static_cast<vdisp_connection>(client->client.connection());
}

const char* vdisp_message(const vdisp_client* client) { return client->client.message().c_str(); }
int vdisp_subscribe(vdisp_client* client, const char* topic) { return client->client.subscribe(topic); }
void vdisp_unsubscribe(vdisp_client* client, int topic) { client->client.unsubscribe(topic); }
vdisp_reading vdisp_latest(vdisp_client* client, int topic) { return reading_of(client->client.latest(topic)); }

vdisp_reading vdisp_wait(vdisp_client* client, int topic, int limit_ms) {
  return reading_of(client->client.wait(topic, vdisp::Client::Time(limit_ms)));
}

bool vdisp_wait_set(vdisp_client* client, const int* topics, int count, vdisp_reading* readings, int limit_ms) {
  if (count <= 0) return false;
  std::vector<vdisp::Reading> found(static_cast<size_t>(count));
  const bool complete = client->client.wait_set({topics, found.size()}, found, vdisp::Client::Time(limit_ms));
  for (size_t i = 0; i < found.size(); ++i) readings[i] = reading_of(found[i]);
  return complete;
}

void vdisp_release(vdisp_client* client, int topic) { client->client.release(topic); }
uint64_t vdisp_epoch(const vdisp_client* client) { return client->client.epoch(); }

vdisp_image_info vdisp_describe(const vdisp_image* handle) {
  const vdisp::Image& image = *image_of(handle);
  vdisp_image_info info{};
  info.pixel = static_cast<uint16_t>(image.spec.pixel);
  info.record = image.spec.record;
  info.width = image.spec.width;
  info.height = image.spec.height;
  info.stride = image.spec.stride();
  info.valid = image.valid();
  info.reason = static_cast<uint32_t>(image.reason);
  info.flags = image.flags;
  info.synthetic = (image.flags & vdisp::flag_synthetic) != 0;
  info.sequence = image.sequence;
  info.epoch = image.epoch;
  info.timestamp_ns = image.timestamp_ns;
  info.ready_ns = image.ready_ns;
  info.cell_m = image.grid.cell;
  info.origin_row = image.grid.origin_row;
  info.origin_column = image.grid.origin_column;
  info.min_count = image.grid.min_count;
  return info;
}

const void* vdisp_row(const vdisp_image* handle, int y) {
  const vdisp::Image& image = *image_of(handle);
  return y >= 0 && y < image.spec.height ? image.row<std::byte>(y) : nullptr;
}

const char* vdisp_reason(uint32_t reason) { return vdisp::describe(static_cast<vdisp::Reason>(reason)).data(); }
