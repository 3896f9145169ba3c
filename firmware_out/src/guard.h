// Gathers what may be wrong at a sample, for the table of causes and actions (my1016_protection.h).
#ifndef GUARD_H
#define GUARD_H

#include <stdint.h>

namespace guard {

// Once a sample, after the alarm rules. Gives the largest |PWM| that is allowed from now on.
uint8_t sample();

}  // namespace guard

#endif
