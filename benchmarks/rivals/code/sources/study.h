// The study's pole and gain functions of |PWM| (Table 4.10), as a sketch would have them.
#ifndef STUDY_H
#define STUDY_H

#include <math.h>

static const float TS = 0.25f;

// T''' = K u - a2 T'' - a1 T' - a0 T of the brush; T' = K u - a T of the others.
struct Study {
    float brush_gain, a2, a1, a0;
    float gain[3], a[3];
};

inline void study_of(float u, Study &s) {
    const float re1 = static_cast<float>(0.0005619f * exp(0.01276f * u) - 0.001848f * exp(0.00903f * u));
    const float re2 = static_cast<float>(0.0006881f * exp(0.01372f * u) - 0.002001f * exp(0.009904f * u));
    const float im = (-1.969e-07f * u + 4.718e-05f) * u + 0.0007725f;
    const float re3 = (1.289e-08f * u - 4.812e-06f) * u - 0.0001109f;
    const float pair = re1 * re2 + im * im;
    s.a2 = -(re1 + re2 + re3);
    s.a1 = pair + (re1 + re2) * re3;
    s.a0 = -pair * re3;
    s.brush_gain = (-2.586e-13f * u + 6.931e-11f) * u - 1.912e-10f;
    if (s.brush_gain < 0.0f) {
        s.brush_gain = 0.0f;
    }
    s.gain[0] = -4.721e-07f * u + 0.0001946f;
    s.gain[1] = -4.685e-07f * u + 0.0001932f;
    s.gain[2] = -4.598e-07f * u + 0.0001896f;
    s.a[0] = static_cast<float>(0.0007722f * exp(-0.001092f * u) - 0.0006995f * exp(-0.01156f * u));
    s.a[1] = static_cast<float>(0.0008783f * exp(-0.001394f * u) - 0.0007423f * exp(-0.009215f * u));
    s.a[2] = static_cast<float>(0.0009327f * exp(-0.001456f * u) - 0.0007804f * exp(-0.008379f * u));
}

#endif
