// conversation.cpp: a queue there and a queue back.
// SPDX-License-Identifier: Apache-2.0
#include "probe/view/conversation.h"

#include <utility>

namespace vdisp {

Conversation::Conversation(const std::string& control, std::chrono::milliseconds limit)
    : control_(control, limit), thread_([this] { run(); }) {}

Conversation::~Conversation() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  woken_.notify_one();
  thread_.join();
}

bool Conversation::ask(Wish wish) {
  bool replaces = false;
  {
    const std::lock_guard lock(mutex_);
    if (!wishes_.empty()) {
      const Wish& before = wishes_.back();
      const bool one_step = wish.joined || !before.joined;
      replaces = wish.kind == Wish::Kind::set && before.kind == Wish::Kind::set && before.key == wish.key && one_step;
    }
    if (replaces) {
      wishes_.back().value = std::move(wish.value);
    } else {
      wishes_.push_back(std::move(wish));
    }
  }
  woken_.notify_one();
  return !replaces;
}

std::optional<WishAnswer> Conversation::hear() {
  const std::lock_guard lock(mutex_);
  if (answers_.empty()) return std::nullopt;
  std::optional<WishAnswer> answer = std::move(answers_.front());
  answers_.pop_front();
  return answer;
}

void Conversation::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    woken_.wait(lock, [this] { return ending_ || !wishes_.empty(); });
    if (ending_) return;
    const Wish wish = std::move(wishes_.front());
    wishes_.pop_front();
    lock.unlock();
    WishAnswer answer = talk(wish);
    lock.lock();
    answers_.push_back(std::move(answer));
  }
}

WishAnswer Conversation::talk(const Wish& wish) {
  WishAnswer answer{wish, Control::Result::no_answer, {}, {}, {}};
  switch (wish.kind) {
    case Wish::Kind::all: answer.result = control_.get_all(answer.all); break;
    case Wish::Kind::undo: answer.result = control_.undo(&answer.info); break;
    case Wish::Kind::save: answer.result = control_.save(); break;
    case Wish::Kind::set:
      answer.result = wish.joined ? control_.adjust(wish.key, wish.value, &answer.info) : control_.set(wish.key, wish.value, &answer.info);
      break;
  }
  answer.message = control_.message();
  return answer;
}

}  // namespace vdisp
