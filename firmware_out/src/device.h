// What the device knows at the present sample.
#ifndef DEVICE_H
#define DEVICE_H

#include <my1016_alarms.h>
#include <stdint.h>

namespace device {

// Upper byte of the flags on the serial line; the lower one is my1016_flags().
enum {
    LATE = 0x0100,     // this sample was taken late
    DROPPED = 0x0200,  // rows were dropped since the last one: the serial line was too slow
    STALL = 0x0400,    // PWM, and no pulse of the encoder for too long
    MEMORY = 0x0800,   // the last copy in EEPROM could not be written
    AMBIENT = 0x1000,  // no believed sample of the ambient temperature now: the last one goes on
    STOPPED = 0x2000   // an alarm has stopped the motor
};

struct Now {
    uint32_t seconds;  // since the model's start ..
    uint16_t milliseconds;
    bool started;
    my1016_Sample sample;
    uint16_t flags;
    uint16_t rpm;
    uint16_t late;     // samples taken late since reset
    uint16_t dropped;  // rows dropped since reset
    uint32_t longest_us;  // longest tick since reset
};

extern Now now;

}  // namespace device

#endif
