// A motor that is the emitted model itself, always asked for full PWM and held by the emitted look ahead, with sensors that scatter.
// Arguments: standard deviation of the scatter in K, hours. Prints the warmest brush in mK, and the PWMs after the first hour.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "my1016.h"
#include "my1016_alarms.h"
#include "my1016_forecast.h"

int main(int, char **arguments) {
    const double scatter_K = std::atof(arguments[1]);
    const long samples = std::atol(arguments[2]) * 14400;
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const int32_t ambient_mC = 30000;
    int32_t warmest = 0;
    int acting = 0, least = 255, most = 0;
    my1016_begin();
    my1016_alarms_begin(1);
    my1016_forecast_begin();
    for (long sample = 0; sample < samples; ++sample) {
        my1016_step(static_cast<int16_t>(acting));
        my1016_Sample seen = my1016_Sample();
        seen.ambient_mC = ambient_mC;
        seen.valid = (1u << MY1016_COMPONENTS) - 1;
        for (uint8_t part = 0; part < MY1016_COMPONENTS; ++part) {
            const double reading = my1016_temperature_mC(part, ambient_mC) + 1000.0 * scatter_K * normal(random);
            seen.measured_mC[part] = static_cast<int32_t>(std::lround(reading / 250.0)) * 250;
        }
        const int32_t brush = my1016_temperature_mC(0, ambient_mC);
        warmest = brush > warmest ? brush : warmest;
        acting = my1016_forecast_near() ? my1016_forecast_most_pwm() : 255;
        if (sample > 14400) {
            least = acting < least ? acting : least;
            most = acting > most ? acting : most;
        }
        my1016_forecast_sample(255, &seen);
        while (my1016_forecast_work(100)) {
        }
    }
    std::printf("%ld %d %d\n", static_cast<long>(warmest), least, most);
    return 0;
}
