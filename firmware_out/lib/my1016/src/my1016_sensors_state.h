// What the checks of the thermocouples' samples keep in RAM.
#ifndef MY1016_SENSORS_STATE_H
#define MY1016_SENSORS_STATE_H

#include "my1016_sensors.h"

struct my1016_Sensor {
    uint8_t code;        // of the last sample
    uint8_t run;         // consistent samples in a row, up to 4
    uint8_t agreed;      // samples in a row that could be a failing part's, up to 4
    bool known;          // there is a believed sample
    bool watching;       // `unchanged`, `moved` and `model_mC` are about the present model and count
    bool displaced;      // it jumped farther than physics allows, and has not come back
    bool rebase;         // the model was set anew: `then_mC` is to be taken again
    bool moved;          // the model moved by more than stuck_mK since the count changed
    int16_t latest[4];  // samples with a sound word, the last one first
    int16_t believed;               // the last sample that passed every check
    uint16_t since;      // samples since then
    uint32_t unchanged;  // samples since the count changed
    int32_t model_mC;    // the model's temperature then
    int32_t then_mC;     // the model's temperature at the last believed sample
};

extern my1016_Sensor my1016_sensors[MY1016_SENSORS];

// Goes on with what a channel had come to before a reset of the board, if it was refused then: it jumped and did not come back, or
// it was frozen. Call it once the model goes on from before the reset, too.
void my1016_sensors_restore(uint8_t channel, const my1016_Sensor *before);

#endif
