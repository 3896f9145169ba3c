// What the device knows at the present sample.
#ifndef DEVICE_H
#define DEVICE_H

#include <my1016_alarms.h>
#include <stdint.h>

namespace device {

// Upper byte of the flags on the serial line; the lower one is my1016_flags().
constexpr uint16_t LATE = 0x0100;     // this sample was taken late
constexpr uint16_t DROPPED = 0x0200;  // rows were dropped since the last one: the serial line was too slow
constexpr uint16_t STALL = 0x0400;    // PWM, and no pulse of the encoder for too long
constexpr uint16_t MEMORY = 0x0800;   // the last copy in EEPROM could not be written
constexpr uint16_t AMBIENT = 0x1000;  // no believed sample of the ambient temperature now: the last one goes on
constexpr uint16_t STOPPED = 0x2000;  // the motor has to stand
constexpr uint16_t NOISY = 0x4000;    // more pulses of the encoder than the motor can give: no speed now
constexpr uint16_t CHANNEL = 0x8000;  // a channel is out of its range now: the last believed value goes on

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
