// recorded_odometry.cpp: CSV or KITTI, told apart by the first line.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/recorded_odometry.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "daemon/sources/source.h"

namespace vdisp {
namespace {

constexpr int64_t longest_gap_ns = 1'000'000'000;
constexpr double farthest = 1e5;  // m: the headers of grids hold floats, a centimetre there

[[noreturn]] void refuse(const std::string& file, size_t line, const std::string& what) {
  throw SourceError(78, "[image source] odometry = " + file + ", line " + std::to_string(line) + ": " + what);
}

std::string trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t\r"), end = text.find_last_not_of(" \t\r");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

template <class Number>
bool parse(const std::string& text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(trimmed(field));
  return fields;
}

std::vector<std::string> lines_of(const std::string& name) {
  std::ifstream file(name);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(trimmed(line));
  if (!file.eof()) throw SourceError(66, "[image source] odometry = " + name + ": cannot be read; needed is a CSV or KITTI's poses.txt");
  while (!lines.empty() && lines.back().empty()) lines.pop_back();
  return lines;
}

Odometry unknown() {
  Odometry pose{};
  for (double* value : {&pose.x, &pose.y, &pose.z, &pose.roll, &pose.pitch, &pose.yaw, &pose.speed, &pose.turn_rate,
                        &pose.position_deviation, &pose.yaw_deviation})
    *value = std::nan("");
  return pose;
}

double* column(Odometry& pose, const std::string& name) {
  if (name == "x") return &pose.x;
  if (name == "y") return &pose.y;
  if (name == "z") return &pose.z;
  if (name == "roll") return &pose.roll;
  if (name == "pitch") return &pose.pitch;
  if (name == "yaw") return &pose.yaw;
  if (name == "speed") return &pose.speed;
  return name == "turn_rate" ? &pose.turn_rate : nullptr;
}

/// From z ahead, x right, y down to x forward, y left, z up.
Odometry rover_pose(const double (&m)[12]) {
  Odometry pose = unknown();
  const double right_down = m[4], down_down = m[5], ahead_right = m[2], ahead_down = m[6], ahead_ahead = m[10];
  pose.x = m[11];
  pose.y = -m[3];
  pose.z = -m[7];
  pose.yaw = std::atan2(-ahead_right, ahead_ahead);
  pose.pitch = std::asin(std::clamp(ahead_down, -1.0, 1.0));
  pose.roll = std::atan2(right_down, down_down);
  return pose;
}

}  // namespace

RecordedOdometry::RecordedOdometry(const std::string& file) {
  const std::vector<std::string> lines = lines_of(file);
  if (lines.empty()) refuse(file, 1, "the file is empty; needed is a CSV or KITTI's poses.txt");
  const bool letters = std::any_of(lines[0].begin(), lines[0].end(), [](char c) { return c >= 'f' && c <= 'z'; });
  if (letters || lines[0].find(',') != std::string::npos) {
    read_csv(file, lines);
  } else {
    read_kitti(file, lines);
  }
}

void RecordedOdometry::read_kitti(const std::string& file, const std::vector<std::string>& lines) {
  by_number_ = of_camera_ = true;
  for (size_t i = 0; i < lines.size(); ++i) {
    std::istringstream stream(lines[i]);
    double m[12];
    int count = 0;  // of numbers; more than 12 where one is none
    for (std::string word; stream >> word; ++count)
      if (count < 12 && (!parse(word, m[count]) || !std::isfinite(m[count]))) count = 12;
    if (count != 12) refuse(file, i + 1, "must be 12 numbers, a 3x4 matrix (KITTI), or the file a CSV");
    poses_.push_back(rover_pose(m));
    poses_.back().timestamp_ns = static_cast<int64_t>(i);
  }
}

void RecordedOdometry::read_csv(const std::string& file, const std::vector<std::string>& lines) {
  const std::vector<std::string> names = fields_of(lines[0]);
  const auto has = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  if (!has("x") || !has("y") || !has("yaw") || has("frame") == has("timestamp_ns"))
    refuse(file, 1, "'" + lines[0] + "' must name the columns x, y, yaw, and timestamp_ns or frame");
  by_number_ = has("frame");
  for (size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> fields = fields_of(lines[i]);
    if (fields.size() != names.size())
      refuse(file, i + 1, std::to_string(fields.size()) + " fields, the first line names " + std::to_string(names.size()));
    Odometry pose = unknown();
    for (size_t f = 0; f < names.size(); ++f) {
      double* value = column(pose, names[f]);
      const bool stamp = names[f] == "frame" || names[f] == "timestamp_ns";
      const bool good = stamp ? parse(fields[f], pose.timestamp_ns) : !value || (parse(fields[f], *value) && !std::isinf(*value));
      if (!good) refuse(file, i + 1, names[f] + " = '" + fields[f] + "', must be a " + (stamp ? "whole number" : "number"));
    }
    if (!std::isfinite(pose.x) || !std::isfinite(pose.y) || !std::isfinite(pose.yaw)) refuse(file, i + 1, "x, y and yaw must be finite");
    if (std::abs(pose.x) > farthest || std::abs(pose.y) > farthest)
      refuse(file, i + 1, "x and y must be within 100 km: take them from the start of the drive");
    if (!poses_.empty() && pose.timestamp_ns <= poses_.back().timestamp_ns)
      refuse(file, i + 1, (by_number_ ? "frame " : "time ") + std::to_string(pose.timestamp_ns) + " is not after the line before");
    poses_.push_back(pose);
  }
}

Odometry RecordedOdometry::by_time(int64_t timestamp_ns) const {
  const auto after =
      std::lower_bound(poses_.begin(), poses_.end(), timestamp_ns, [](const Odometry& a, int64_t t) { return a.timestamp_ns < t; });
  if (after == poses_.end()) return unknown();
  if (after->timestamp_ns == timestamp_ns) return *after;
  if (by_number_ || after == poses_.begin()) return unknown();
  const Odometry &a = *(after - 1), &b = *after;
  if (b.timestamp_ns - a.timestamp_ns > longest_gap_ns) return unknown();
  const double part = static_cast<double>(timestamp_ns - a.timestamp_ns) / static_cast<double>(b.timestamp_ns - a.timestamp_ns);
  Odometry pose = a;
  const auto between = [part](double from, double to) { return from + (to - from) * part; };
  pose.x = between(a.x, b.x);
  pose.y = between(a.y, b.y);
  pose.z = between(a.z, b.z);
  pose.roll = between(a.roll, b.roll);
  pose.pitch = between(a.pitch, b.pitch);
  pose.yaw = std::remainder(a.yaw + std::remainder(b.yaw - a.yaw, 2 * M_PI) * part, 2 * M_PI);
  pose.speed = between(a.speed, b.speed);
  pose.turn_rate = between(a.turn_rate, b.turn_rate);
  return pose;
}

Odometry RecordedOdometry::at(int64_t number, int64_t timestamp_ns, const mounting_section& mounting) const {
  Odometry pose = by_time(by_number_ ? number : timestamp_ns);
  pose.timestamp_ns = timestamp_ns;
  if (!of_camera_) return pose;
  pose.yaw = std::remainder(pose.yaw - mounting.yaw, 2 * M_PI);
  pose.x -= std::cos(pose.yaw) * mounting.x - std::sin(pose.yaw) * mounting.y;
  pose.y -= std::sin(pose.yaw) * mounting.x + std::cos(pose.yaw) * mounting.y;
  return pose;
}

}  // namespace vdisp
