// records.h: results that are no picture: fixed structs that travel as images of kind record. Each subject has its own header.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "records/calibration_watch.h"  // beside this file in the tree and where it is installed
#include "records/cameras.h"
#include "records/catalogue.h"
#include "records/drive.h"
#include "records/floor.h"
#include "records/health.h"
#include "records/inputs.h"
#include "records/map_changes.h"
#include "records/memory.h"
#include "records/record.h"
#include "records/recorder.h"
#include "records/truth.h"
