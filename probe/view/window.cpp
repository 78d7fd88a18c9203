// window.cpp: the only file that knows SDL. It draws through the window's surface: no OpenGL, also under Xvfb and ssh -X.
// SPDX-License-Identifier: Apache-2.0
#include "probe/view/window.h"

#include <SDL2/SDL.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vdisp {

struct Window::Implementation {
  SDL_Window* window = nullptr;
  bool inside = false;
  int x = -1, y = -1;
  bool drives = false;
  Hands hands;
  SDL_GameController* gamepad = nullptr;

  /// The event was one that drives.
  bool drive(const SDL_Event& event);
  void look_at_gamepad();
};

namespace {

constexpr uint64_t poll_ms = 5;

std::optional<Input> key_input(const SDL_KeyboardEvent& key, bool drives) {
  switch (key.keysym.sym) {
    case SDLK_DOWN:
    case SDLK_PAGEDOWN: return Input::next_stage;
    case SDLK_UP:
    case SDLK_PAGEUP: return Input::previous_stage;
    case SDLK_RIGHT: return Input::next_image;
    case SDLK_LEFT: return Input::previous_image;
    case SDLK_q:
    case SDLK_ESCAPE: return Input::quit;
    case SDLK_c: return Input::palette;
    case SDLK_s: return Input::save;
    case SDLK_SPACE: return Input::space;
    case SDLK_u:
    case SDLK_BACKSPACE: return Input::undo;
    case SDLK_t: return Input::tree;
    case SDLK_p: return Input::panel;
    case SDLK_TAB:  // where the arrow keys drive, there is no other for images
      if (drives) return Input::next_image;
      return key.keysym.mod & KMOD_SHIFT ? Input::previous_slider : Input::next_slider;
    case SDLK_w: return Input::write;
    case SDLK_a: return Input::all_sliders;
    case SDLK_F1:
    case SDLK_h: return Input::help;
    default: return {};
  }
}

constexpr double stick_rest = 0.2;  // of its way: sticks do not come back to their middle exactly

double beyond_rest(int axis) {
  const double part = std::clamp(axis / 32767.0, -1.0, 1.0);
  return std::abs(part) <= stick_rest ? 0 : (part - std::copysign(stick_rest, part)) / (1 - stick_rest);
}

}  // namespace

bool Window::Implementation::drive(const SDL_Event& event) {
  switch (event.type) {
    case SDL_KEYDOWN:
    case SDL_KEYUP: {
      const bool held = event.type == SDL_KEYDOWN;
      switch (event.key.keysym.sym) {
        case SDLK_UP: hands.up = held; return true;
        case SDLK_DOWN: hands.down = held; return true;
        case SDLK_LEFT: hands.left = held; return true;
        case SDLK_RIGHT: hands.right = held; return true;
        default: return false;
      }
    }
    case SDL_MOUSEBUTTONDOWN:
    case SDL_MOUSEBUTTONUP: {
      const bool held = event.type == SDL_MOUSEBUTTONDOWN;
      if (event.button.button == SDL_BUTTON_LEFT) hands.mouse_left = held;
      if (event.button.button == SDL_BUTTON_RIGHT) hands.mouse_right = held;
      if (event.button.button == SDL_BUTTON_MIDDLE && held) {
        hands.mouse = false;
      } else if (held) {
        hands.mouse = true;
      }
      return true;
    }
    case SDL_WINDOWEVENT:
      if (event.window.event == SDL_WINDOWEVENT_FOCUS_LOST) hands = {};
      if (event.window.event == SDL_WINDOWEVENT_FOCUS_GAINED) hands.focus = true;
      if (event.window.event == SDL_WINDOWEVENT_LEAVE) hands.mouse = hands.mouse_left = hands.mouse_right = false;
      return false;
    case SDL_CONTROLLERDEVICEADDED:
      if (!gamepad) gamepad = SDL_GameControllerOpen(event.cdevice.which);
      return true;
    case SDL_CONTROLLERDEVICEREMOVED:
      if (gamepad) SDL_GameControllerClose(gamepad);
      gamepad = nullptr;
      return true;
    default: return false;
  }
}

void Window::Implementation::look_at_gamepad() {
  hands.stick = false;
  if (!gamepad || !SDL_GameControllerGetAttached(gamepad)) return;
  const auto pressed = [&](SDL_GameControllerButton button) { return static_cast<int>(SDL_GameControllerGetButton(gamepad, button)); };
  hands.stick_ahead = -beyond_rest(SDL_GameControllerGetAxis(gamepad, SDL_CONTROLLER_AXIS_LEFTY)) + pressed(SDL_CONTROLLER_BUTTON_DPAD_UP) -
                      pressed(SDL_CONTROLLER_BUTTON_DPAD_DOWN);
  hands.stick_left = -beyond_rest(SDL_GameControllerGetAxis(gamepad, SDL_CONTROLLER_AXIS_LEFTX)) +
                     pressed(SDL_CONTROLLER_BUTTON_DPAD_LEFT) - pressed(SDL_CONTROLLER_BUTTON_DPAD_RIGHT);
  hands.stick_ahead = std::clamp(hands.stick_ahead, -1.0, 1.0);
  hands.stick_left = std::clamp(hands.stick_left, -1.0, 1.0);
  hands.stick = hands.focus && (hands.stick_ahead != 0 || hands.stick_left != 0);
}

Window::Window(const std::string& title, int width, int height, bool drives) : implementation_(std::make_unique<Implementation>()) {
  // Left alone, SDL would fall back to a window that nobody sees.
  if (!std::getenv("SDL_VIDEODRIVER")) {
    const bool x11 = std::getenv("DISPLAY"), wayland = std::getenv("WAYLAND_DISPLAY");
    if (!x11 && !wayland) throw NoWindow("no display for a window (neither DISPLAY nor WAYLAND_DISPLAY is set)");
    SDL_SetHint(SDL_HINT_VIDEODRIVER, x11 && wayland ? "x11,wayland" : x11 ? "x11" : "wayland");
  }
  SDL_SetHint(SDL_HINT_VIDEO_ALLOW_SCREENSAVER, "1");
  SDL_SetHint(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0");  // else OpenGL, and without a graphics card its emulation
  implementation_->drives = drives;
  if (SDL_Init(SDL_INIT_VIDEO) != 0) throw NoWindow(std::string("no display for a window (SDL: ") + SDL_GetError() + ")");
  SDL_Rect usable;
  if (SDL_GetDisplayUsableBounds(0, &usable) == 0) width = std::min(width, usable.w), height = std::min(height, usable.h);
  implementation_->window =
      SDL_CreateWindow(title.c_str(), SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, width, height, SDL_WINDOW_RESIZABLE);
  if (!implementation_->window) {
    const std::string error = SDL_GetError();
    SDL_Quit();
    throw NoWindow("cannot open a window (SDL: " + error + ")");
  }
  SDL_SetWindowMinimumSize(implementation_->window, 360, 280);
  if (drives) SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER);  // without one there are still keys and mouse
}

Window::~Window() {
  if (implementation_->gamepad) SDL_GameControllerClose(implementation_->gamepad);
  SDL_DestroyWindow(implementation_->window);
  SDL_Quit();
}

std::optional<Input> Window::wait(int limit_ms) {
  SDL_Event event;
  const auto until = SDL_GetTicks64() + static_cast<uint64_t>(std::max(limit_ms, 0));
  while (true) {
    // Not SDL_WaitEventTimeout: it wakes itself by messages over a second connection to the X server, and one that arrives after the
    // window is gone ends the program with BadWindow.
    if (!SDL_PollEvent(&event)) {
      if (implementation_->drives) implementation_->look_at_gamepad();
      const uint64_t now = SDL_GetTicks64();
      if (now >= until) return {};
      SDL_Delay(static_cast<uint32_t>(std::min<uint64_t>(until - now, poll_ms)));
      continue;
    }
    if (implementation_->drives && implementation_->drive(event)) return Input::moved;
    switch (event.type) {
      case SDL_QUIT: return Input::quit;
      case SDL_KEYDOWN:
        if (const auto input = key_input(event.key, implementation_->drives)) return input;
        break;
      case SDL_TEXTINPUT:  // '?', '+' and '-' sit on another key on each keyboard
        if (event.text.text[0] == '?') return Input::help;
        if (event.text.text[0] == '+') return Input::more;
        if (event.text.text[0] == '-') return Input::less;
        break;
      case SDL_MOUSEBUTTONDOWN:
        implementation_->x = event.button.x, implementation_->y = event.button.y;
        if (event.button.button == SDL_BUTTON_LEFT) return Input::pressed;
        if (event.button.button == SDL_BUTTON_RIGHT) return Input::previous_stage;
        break;
      case SDL_MOUSEBUTTONUP:
        if (event.button.button == SDL_BUTTON_LEFT) return Input::released;
        break;
      case SDL_MOUSEWHEEL:
        if (event.wheel.y != 0) return event.wheel.y < 0 ? Input::next_image : Input::previous_image;
        break;
      case SDL_MOUSEMOTION: implementation_->x = event.motion.x, implementation_->y = event.motion.y; return Input::moved;
      case SDL_WINDOWEVENT:
        if (event.window.event == SDL_WINDOWEVENT_LEAVE) implementation_->x = implementation_->y = -1;
        return Input::moved;
      default: break;
    }
  }
}

void Window::show(const Picture& picture) {
  SDL_Surface* target = SDL_GetWindowSurface(implementation_->window);
  if (!target || target->format->BytesPerPixel != 4 || SDL_LockSurface(target) != 0) return;
  const int red = target->format->Rshift, green = target->format->Gshift, blue = target->format->Bshift;
  for (int y = 0; y < std::min(picture.height(), target->h); ++y) {
    const Colour* from = picture.row(y);
    auto* to = reinterpret_cast<uint32_t*>(static_cast<char*>(target->pixels) + static_cast<size_t>(y) * target->pitch);
    const int width = std::min(picture.width(), target->w);
    for (int x = 0; x < width; ++x) to[x] = uint32_t{from[x].r} << red | uint32_t{from[x].g} << green | uint32_t{from[x].b} << blue;
  }
  SDL_UnlockSurface(target);
  SDL_UpdateWindowSurface(implementation_->window);
}

void Window::set_title(const std::string& title) { SDL_SetWindowTitle(implementation_->window, title.c_str()); }

int Window::width() const {
  int width = 0;
  SDL_GetWindowSize(implementation_->window, &width, nullptr);
  return width;
}

int Window::height() const {
  int height = 0;
  SDL_GetWindowSize(implementation_->window, nullptr, &height);
  return height;
}

const Hands& Window::hands() const { return implementation_->hands; }
int Window::mouse_x() const { return implementation_->x; }
int Window::mouse_y() const { return implementation_->y; }

}  // namespace vdisp
