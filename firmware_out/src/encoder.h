// Speed feedback: 500 pulses in a revolution.
#ifndef ENCODER_H
#define ENCODER_H

#include <stdint.h>

namespace encoder {

void begin();

// Once a sample: the pulses since the last time. `pwm` is what acted meanwhile, for the detection of a stall.
void sample(int16_t pwm);

uint16_t rpm();

// True if there were more pulses than the motor can give (3313 rpm): a broken or noisy line; rpm() means nothing then.
bool noisy();
bool stalled();

}  // namespace encoder

#endif
