// What the model keeps in RAM.
#ifndef MY1016_MODEL_H
#define MY1016_MODEL_H

#include "my1016_step.h"

struct my1016_State {
    my1016_A_State a[1];  // brush
    my1016_B_State b[3];  // bearing, magnet, casing
    int32_t ambient_mK;  // what the ambient that was told last is over 30000 thousandths of a degree Celsius
};

// Coefficients of one PWM.
struct my1016_Coefficients {
    my1016_A_Rates a[1];  // brush
    my1016_B_Rates b[3];  // bearing, magnet, casing
};

struct my1016_Model {
    my1016_State state;
    my1016_Coefficients now;
    int32_t ambient[2];  // ambient_mK as words of A, B
    int16_t command;  // the PWM of the last sample, as commanded
    uint8_t flags;    // see my1016.h; the highest bit is the model's own
};

extern my1016_Model my1016_model;

// The coefficients of a |PWM| within the domain 0..255.
void my1016_schedule(uint8_t pwm, my1016_Coefficients *coefficients);

#endif
