// Which samples of the thermocouples may be used. Pure logic: it takes the words that the chips sent.
//
// A sample is believed when its word is sound, its value plausible, not frozen, within reach of the last believed one at the
// physical rate, and (at the start, after a fault or a jump) confirmed by the 3 before it. A rise beyond that rate is
// believed once the last samples show that it goes on. A sample is plausible, believed or not, when it is the 3rd sound one in a
// row that could be one part's. Its twin in Python is gen/reference/sensors.py; limits come from $.wiring.thermocouples
// and are listed in my1016_sensors.cpp.
#ifndef MY1016_SENSORS_H
#define MY1016_SENSORS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// Thermocouples in the order of the coefficient file.
enum {
    MY1016_SENSOR_BRUSH,
    MY1016_SENSOR_BEARING,
    MY1016_SENSOR_MAGNET,
    MY1016_SENSOR_CASING,
    MY1016_SENSOR_AMBIENT,
    MY1016_SENSORS
};

// What my1016_sensors_check() says of a sample: one digit on the serial line.
enum {
    MY1016_SAMPLE_OK = 0,           // believed
    MY1016_SAMPLE_OPEN = 1,         // the chip says that its thermocouple is open (or shorted)
    MY1016_SAMPLE_ZEROS = 2,        // all bits 0: no supply, or SO at ground
    MY1016_SAMPLE_ONES = 3,         // no word of this chip: all bits 1 (nobody answers), noise, or a chip of another kind
    MY1016_SAMPLE_RANGE = 4,        // outside the physical range
    MY1016_SAMPLE_JUMP = 5,         // farther from the sample before, or the last believed one, than physics allows; until it is back
    MY1016_SAMPLE_STUCK = 6,        // the same count for too long, although the model moved
    MY1016_SAMPLE_EARLY = 7,        // the conversion was not finished (a late loop): not read
    MY1016_SAMPLE_UNCONFIRMED = 8,  // plausible, but fewer than 4 in a row yet
    MY1016_SAMPLE_UNREAD = 9        // nothing was read yet
};

// Forgets everything.
void my1016_sensors_begin(void);

// Judges one reading of a channel: the chip's bits as thermocouples::read() gives them, whether its conversion had the time that it needs (220 ms), and
// the model's temperature of this part in thousandths of a degree (a constant where there is no model). Call it once
// every 250 ms; returns one of the codes above.
uint8_t my1016_sensors_check(uint8_t channel, uint32_t word, uint8_t finished, int32_t model_mC);

// Says that the model was started anew: what it moved before says nothing about a sensor.
void my1016_sensors_model_set(void);

// Somebody has looked at a channel's sensor: if it had jumped it is confirmed where it is now, as at the start.
void my1016_sensors_accept(uint8_t channel);

// The last code of a channel.
uint8_t my1016_sensors_code(uint8_t channel);

// The last believed sample of a channel in thousandths of a degree Celsius; 0 before the first.
int32_t my1016_sensors_mC(uint8_t channel);

// Whether the last sample may be the truth, believed or not: what a limit that protects has to heed.
uint8_t my1016_sensors_plausible(uint8_t channel);

// The last sample with a sound word in thousandths of a degree Celsius: of a plausible one what it says.
int32_t my1016_sensors_plausible_mC(uint8_t channel);

// By how much it rose over the last two readings and over the two before the last one, the smaller of both, without what noise
// is, in thousandths of a kelvin: what a limit that protects looks ahead with. 0 unless the last four readings could be one part's.
uint16_t my1016_sensors_rising_mK(uint8_t channel);

#ifdef __cplusplus
}
#endif

#endif
