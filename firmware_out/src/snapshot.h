// The model's states and what was measured when they were kept: enough to go on from, and to see whether that is still true.
#ifndef SNAPSHOT_H
#define SNAPSHOT_H

#include <my1016_model.h>
#include <my1016_sensors.h>
#include <stdint.h>

namespace snapshot {

struct Snapshot {
    int16_t pwm;  // of the sample before
    uint16_t measured[MY1016_SENSORS];  // believed samples in counts of 0.25 degC (int16_t), or one that no chip gives
    my1016_State state;
};

// What holds now.
void take(Snapshot *to);

// Whether a part that was measured then is measured now, and all such parts are within $.wiring.memory.tolerance_K of where they
// were. Measurements are compared, not the model: a faulty motor is rightly off its model.
bool is_true(const Snapshot &of);

// Puts it into the model.
void put(const Snapshot &from);

}  // namespace snapshot

#endif
