// Where constants live: in flash on the AVR (they would fill its RAM otherwise), plain memory elsewhere.
#ifndef MY1016_PLATFORM_H
#define MY1016_PLATFORM_H

#include <stdint.h>

#ifdef __AVR__
#include <avr/pgmspace.h>
// What a sample at constant PWM does not need is to be small.
#define MY1016_SMALL __attribute__((noinline, optimize("Os")))
// What every change of PWM needs costs no call.
#define MY1016_INLINE __attribute__((always_inline))
#else
#define MY1016_INLINE
#include <string.h>
#define MY1016_SMALL
#ifndef PROGMEM
#define PROGMEM
#endif
#ifndef memcpy_P
#define memcpy_P memcpy
#endif
#ifndef pgm_read_byte
#define pgm_read_byte(address) (*(address))
#endif
#ifndef pgm_read_word
#define pgm_read_word(address) (*(address))
#endif
#ifndef pgm_read_dword
#define pgm_read_dword(address) (*(address))
#endif
#ifndef pgm_read_float
#define pgm_read_float(address) (*(address))
#endif
#endif

#endif
