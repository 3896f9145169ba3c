// The sketch: every 250 ms the model takes one step, and once a second its temperatures go out on the serial line
// as rows of a run file (`time_s,pwm,...`). Send a number and a newline to tell it the PWM that now acts.
//
// The tick has three places: before the step, where the sensors will be read; the step; and after it, where the
// measured temperatures will be compared with the model's and alarms raised.
#include <Arduino.h>

#include <my1016.h>

static const uint32_t BAUD = 115200;
static const int32_t AMBIENT_MC = 30000;  // from $.ambient.fixed_degC, in thousandths of a degree
static const uint8_t ROW_TICKS = 4;  // ticks between two rows
static const uint8_t ROW_BYTES = 16 + 12 * MY1016_COMPONENTS;  // no longer than this, so that it fits behind the last row

static uint32_t tick_due;
static uint32_t ticks;
static uint8_t ticks_to_row;
static int16_t pwm;

// Prints thousandths as a decimal number.
static void print_thousandths(int32_t value) {
    if (value < 0) {
        Serial.print('-');
        value = -value;
    }
    Serial.print(value / 1000);
    Serial.print('.');
    const int16_t rest = (int16_t)(value % 1000);
    if (rest < 100) {
        Serial.print('0');
    }
    if (rest < 10) {
        Serial.print('0');
    }
    Serial.print(rest);
}

static void print_header() {
    Serial.println(F("# model: my1016"));
    Serial.println(F("# coefficients_sha256: 9ef57c76389da99307b100ae5e00bf54ac82196c1fdc36e8b43851183adf39a8"));
    Serial.print(F("time_s,pwm"));
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        Serial.print(',');
        Serial.print((const __FlashStringHelper *)my1016_component_name(component));
        Serial.print(F("_model_degC"));
    }
    Serial.println(F(",flags"));
}

static void print_row() {
    print_thousandths((int32_t)(ticks * MY1016_SAMPLE_MS));
    Serial.print(',');
    Serial.print(pwm);
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        Serial.print(',');
        print_thousandths(my1016_temperature_mC(component, AMBIENT_MC));
    }
    Serial.print(',');
    Serial.println(my1016_flags());
}

// Takes what has arrived of a command, "-255".."255" and a newline; never waits. Anything else in a line voids it.
static void read_command() {
    static int16_t number;
    static bool negative, digits, valid = true;
    while (Serial.available() > 0) {
        const char c = (char)Serial.read();
        if (c >= '0' && c <= '9' && number <= 255) {
            number = (int16_t)(number * 10 + (c - '0'));
            digits = true;
        } else if (c == '-' && !digits && !negative) {
            negative = true;
        } else if (c == '\n' || c == '\r') {
            if (digits && valid && number <= 255) {
                pwm = negative ? (int16_t)-number : number;
            }
            number = 0;
            negative = digits = false;
            valid = true;
        } else {
            valid = false;
        }
    }
}

void setup() {
    Serial.begin(BAUD);
    my1016_begin();
    print_header();
    tick_due = millis() + MY1016_SAMPLE_MS;
}

void loop() {
    read_command();
    if ((int32_t)(millis() - tick_due) < 0) {  // the difference is right across the rollover of millis()
        return;
    }
    tick_due += MY1016_SAMPLE_MS;

    // Before the step: read and check the sensors here.

    my1016_step(pwm);
    ++ticks;

    // After the step: compare measured and modelled temperatures and raise alarms here.

    if (ticks_to_row > 0) {
        --ticks_to_row;
    } else if (Serial.availableForWrite() >= (ROW_BYTES < SERIAL_TX_BUFFER_SIZE ? ROW_BYTES : SERIAL_TX_BUFFER_SIZE - 1)) {
        ticks_to_row = ROW_TICKS - 1;
        print_row();
    }
}
