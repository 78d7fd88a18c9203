// failure.cpp: every kind of error that building and dumping throw, and its exit code.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/failure.h"

#include <sysexits.h>

#include <iostream>
#include <new>

#include "daemon/control/inlet.h"
#include "daemon/service/realtime.h"
#include "daemon/snow/model.h"
#include "daemon/sources/source.h"
#include "ipc/png.h"
#include "ipc/shm.h"

namespace vdisp {
namespace {

int say(int exit_code, const std::string& what) {
  std::cerr << "vdispd: " << what << std::endl;
  return exit_code;
}

}  // namespace

int explain(std::exception_ptr failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const SourceError& error) {
    return say(error.exit_code, error.what());
  } catch (const ShmError& error) {
    return say(error.exit_code, error.what());
  } catch (const ControlError& error) {
    return say(error.exit_code, error.what());
  } catch (const RealtimeError& error) {
    return say(error.exit_code, error.what());
  } catch (const snow::ModelError& error) {
    return say(error.exit_code, error.what());
  } catch (const WriteError& error) {
    return say(error.exit_code, error.what());
  } catch (const CalibrationError& error) {
    return say(EX_CONFIG, error.what());
  } catch (const FormatError& error) {
    return say(EX_CONFIG, error.what());
  } catch (const std::bad_alloc&) {
    return say(EX_OSERR, "not enough memory for this tree; free some, raise the limit (ulimit -v, MemoryMax), or take smaller images");
  } catch (const std::exception& error) {
    return say(EX_TEMPFAIL, std::string("internal: ") + error.what());
  }
}

void attempt(std::exception_ptr& failure, const std::function<void()>& act) {
  try {
    act();
  } catch (...) {
    if (!failure) failure = std::current_exception();
  }
}

}  // namespace vdisp
