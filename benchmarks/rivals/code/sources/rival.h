// What each rival defines, and what the harness gives it.
#ifndef RIVAL_H
#define RIVAL_H

#include <stdint.h>

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#include <string.h>
#define PROGMEM
#define pgm_read_float(address) (*(address))
#define pgm_read_dword(address) (*(address))
#define memcpy_P memcpy
#endif

#define RIVAL_PARTS 4

// Rises over ambient of brush, bearing, magnet and casing, in the rival's own words (float kelvins, or integers).
extern RIVAL_WORD rival_rise[RIVAL_PARTS];

// A cold motor.
void rival_begin();
// One sample of 0.25 s with this PWM, -255..255.
void rival_step(int16_t pwm);

inline int16_t rival_magnitude(int16_t pwm) {
    return static_cast<int16_t>(pwm < 0 ? -pwm : pwm);
}

#endif
