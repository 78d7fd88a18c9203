// inlet.cpp: the daemon's end of the control socket while it runs; inlet_open.cpp makes it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/inlet.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "daemon/core/clock.h"

namespace vdisp {
namespace {

constexpr int connections_a_time = 32, messages_a_time = 64;
constexpr int64_t silence_ns = 5'000'000'000;  // who says nothing for so long makes room for others
constexpr int64_t second = 1'000'000'000;
constexpr int flood_rounds = 30;

template <class Message>
Message copied(const char* bytes) {
  Message message;
  std::memcpy(&message, bytes, sizeof message);
  return message;
}

/// A text that does not end would be read beyond its place.
template <size_t size>
void end(char (&text)[size]) {
  text[size - 1] = 0;
}

}  // namespace

void Inlet::serve(uint64_t sequence) noexcept {
  const int64_t now = monotonic_ns();
  accept_clients(now);
  // The oldest first: who has gone is heard to its end before who came in its place, else that one would be the second to send the same.
  uint64_t heard = 0;
  while (Client* client = oldest_after(heard)) {
    heard = client->number;
    listen_to(*client, now);
  }
  LiveParameters::Reply reply;
  while (parameters_.next(reply)) {
    for (Client& client : clients_) {
      if (client.socket < 0 || client.number != reply.client) continue;
      reply.message->sequence = sequence;
      answer(client, *reply.message);
    }
    parameters_.done();
  }
}

/// The connection that came next; null: none did.
Inlet::Client* Inlet::oldest_after(uint64_t number) noexcept {
  Client* oldest = nullptr;
  for (Client& client : clients_)
    if (client.socket >= 0 && client.number > number && (!oldest || client.number < oldest->number)) oldest = &client;
  return oldest;
}

void Inlet::accept_clients(int64_t now_ns) noexcept {
  for (int i = 0; i < connections_a_time; ++i) {
    const int socket = accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    Client newcomer;
    newcomer.socket = socket;
    newcomer.number = ++connections_;
    newcomer.heard_ns = now_ns;
    ucred peer{};
    socklen_t size = sizeof peer;
    if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0) {
      newcomer.pid = peer.pid;
      newcomer.uid = peer.uid;
    }
    if (Client* place = free_place(now_ns)) {
      *place = newcomer;
    } else {
      ++losses_.refused;
      say(full, newcomer, now_ns);
      refuse(socket, Answer::busy, 0);
      close(socket);
    }
  }
}

/// Null: all are taken by clients that speak.
Inlet::Client* Inlet::free_place(int64_t now_ns) noexcept {
  Client* longest = &clients_[0];
  for (Client& client : clients_) {
    if (client.socket < 0) return &client;
    if (client.heard_ns < longest->heard_ns) longest = &client;
  }
  if (now_ns - longest->heard_ns < silence_ns) return nullptr;
  drop(*longest);
  return longest;
}

void Inlet::listen_to(Client& client, int64_t now_ns) noexcept {
  char bytes[sizeof(ParameterMessage) + 1];
  for (int i = 0; i < messages_a_time; ++i) {
    const ssize_t size = recv(client.socket, bytes, sizeof bytes, MSG_DONTWAIT | MSG_TRUNC);
    if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) {
      client.busy_rounds = 0;
      return;
    }
    if (size <= 0) return drop(client);
    client.heard_ns = now_ns;
    if (take(client, bytes, static_cast<size_t>(size), now_ns)) continue;
    ++losses_.closed;
    say(wrong_message, client, now_ns);
    refuse(client.socket, Answer::wrong_message, 0);
    return drop(client);
  }
  if (++client.busy_rounds == flood_rounds) say(flood, client, now_ns);
}

/// False: not of this protocol.
bool Inlet::take(Client& client, const char* bytes, size_t size, int64_t now_ns) noexcept {
  if (size < sizeof(CommandHeader)) return false;
  const auto header = copied<CommandHeader>(bytes);
  if (header.magic != command_magic || header.version != command_version || header.bytes != size) return false;
  const auto input = [&]<class Message>(Message) {
    if (size != sizeof(Message)) return false;
    inputs_.take(copied<Message>(bytes), client.number, now_ns);
    return true;
  };
  switch (header.type) {
    case CommandType::odometry: return input(OdometryMessage{});
    case CommandType::imu: return input(ImuMessage{});
    case CommandType::drive: return input(DriveMessage{});
    case CommandType::event: return input(EventMessage{});
    case CommandType::set:
    case CommandType::get:
    case CommandType::save:
    case CommandType::undo: {
      if (size != sizeof(ParameterMessage)) return false;
      auto message = copied<ParameterMessage>(bytes);
      end(message.key);
      end(message.value);
      if (!parameters_.ask(message, {client.number, client.pid, client.uid})) {
        ++losses_.requests;
        refuse(client.socket, Answer::busy, header.number);
      }
      return true;
    }
    case CommandType::reply: break;
  }
  return false;
}

void Inlet::answer(Client& client, const ReplyMessage& reply) noexcept {
  if (send(client.socket, &reply, sizeof reply, MSG_DONTWAIT | MSG_NOSIGNAL) == sizeof reply) return;
  if (errno == EAGAIN || errno == EWOULDBLOCK) {
    ++losses_.closed;
    say(deaf, client, monotonic_ns());
  }
  drop(client);
}

void Inlet::refuse(int socket, Answer why, uint32_t number) noexcept {
  ReplyMessage reply{};
  reply.header = {command_magic, command_version, CommandType::reply, sizeof reply, number};
  reply.answer = why;
  send(socket, &reply, sizeof reply, MSG_DONTWAIT | MSG_NOSIGNAL);  // who does not read it learns it by the end of the connection
}

void Inlet::drop(Client& client) noexcept {
  inputs_.forget(client.number);
  close(client.socket);
  client = Client{};
}

void Inlet::say(Trouble trouble, const Client& client, int64_t now_ns) noexcept {
  static constexpr const char* words[troubles] = {"refused: all 16 connections are in use",
                                                  "closed: not a message of this version (docs/control.md)",
                                                  "closed: it does not read its replies", "sends more than 64 messages a frame: they wait"};
  Edge& edge = edges_[trouble];
  ++edge.untold;
  if (now_ns - edge.told_ns < second) return;
  char line[200];
  const int length = std::snprintf(line, sizeof line, "control: process %d of user %u %s", static_cast<int>(client.pid),
                                   static_cast<unsigned>(client.uid), words[trouble]);
  size_t used = std::min(static_cast<size_t>(std::max(length, 0)), sizeof line - 1);
  if (edge.untold > 1) {
    const int more = std::snprintf(line + used, sizeof line - used, " (%llu times since the last message)",
                                   static_cast<unsigned long long>(edge.untold));
    used = std::min(used + static_cast<size_t>(std::max(more, 0)), sizeof line - 1);
  }
  tell_({line, used});
  edge = {now_ns, 0};
}

}  // namespace vdisp
