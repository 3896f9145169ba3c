// Answers commands of one letter, so that a test can see what the firmware sees at its pins.
//   r      read the MAX6675s of TABLE by bit-banging, print the words in hex
//   p      print the pulses counted in the interrupt of pin 2, and by Timer 5 on pin 47
//   d      put PWM 77 on pin 4, 200 on pin 5, 255 on pin 6, 0 on pin 7, 128 on pin 9
//   b      print the levels of the button (pin 22, pull-up) after writing its port's other pins
//   w N    write N, one letter, to EEPROM address 17 and do not wait;  e prints that byte
//   m      print millis();  u prints MCUSR and a .noinit variable, then changes the variable
//   a      a long text;  z wait for the watchdog
#include <Arduino.h>
#include <avr/eeprom.h>
#include <avr/wdt.h>

struct Chip {
    uint8_t cs, so, sck;
};
static const Chip TABLE[] = {CHIPS};
static const uint8_t COUNT = sizeof TABLE / sizeof TABLE[0];

static volatile uint32_t pulses;
static uint8_t cause __attribute__((section(".noinit")));
static uint32_t kept __attribute__((section(".noinit")));

void early() __attribute__((naked, used, section(".init3")));
void early() {
    cause = MCUSR;
    MCUSR = 0;
    wdt_disable();
}

static void on_pulse() {
    ++pulses;
}

static uint16_t read_word(const Chip &chip) {
    uint16_t word = 0;
    digitalWrite(chip.cs, LOW);
    for (uint8_t bit = 0; bit < 16; ++bit) {
        digitalWrite(chip.sck, HIGH);
        word = (uint16_t)(word << 1 | digitalRead(chip.so));
        digitalWrite(chip.sck, LOW);
    }
    digitalWrite(chip.cs, HIGH);
    return word;
}

static void print_words() {
    for (uint8_t i = 0; i < COUNT; ++i) {
        Serial.print(read_word(TABLE[i]), HEX);
        Serial.print(i + 1 < COUNT ? ' ' : '\n');
    }
}

void setup() {
    Serial.begin(115200);
    for (uint8_t i = 0; i < COUNT; ++i) {
        digitalWrite(TABLE[i].cs, HIGH);
        pinMode(TABLE[i].cs, OUTPUT);
        pinMode(TABLE[i].sck, OUTPUT);
    }
    pinMode(22, INPUT_PULLUP);
    pinMode(23, OUTPUT);
    pinMode(13, OUTPUT);
    attachInterrupt(digitalPinToInterrupt(2), on_pulse, EDGE);
    TCCR5A = 0;
    TCNT5 = 0;
    TCCR5B = _BV(CS52) | _BV(CS51) | _BV(CS50);
    Serial.println(F("ready"));
}

void loop() {
    const int command = Serial.read();
    switch (command) {
    case 'r': print_words(); break;
    case 'p': {
        noInterrupts();
        const uint32_t now = pulses;
        interrupts();
        Serial.print(now);
        Serial.print(' ');
        Serial.println(TCNT5);
        break;
    }
    case 'd':
        analogWrite(4, 77);
        analogWrite(5, 200);
        analogWrite(6, 255);
        analogWrite(7, 0);
        analogWrite(9, 128);
        break;
    case 'b':
        digitalWrite(23, HIGH);
        digitalWrite(23, LOW);
        Serial.println(digitalRead(22));
        break;
    case 'w':
        while (Serial.available() == 0) {
        }
        EEAR = 17;
        EEDR = (uint8_t)Serial.read();
        noInterrupts();
        EECR = _BV(EEMPE);
        EECR = _BV(EEMPE) | _BV(EEPE);
        interrupts();
        Serial.println(EECR & _BV(EEPE) ? F("busy") : F("idle"));
        break;
    case 'e': Serial.println(eeprom_read_byte((const uint8_t *)17)); break;
    case 'm': Serial.println(millis()); break;
    case 'u':
        Serial.print(cause);
        Serial.print(' ');
        Serial.println(kept);
        kept = 12345;
        break;
    case 'a':
        for (uint16_t i = 0; i < 500; ++i) {
            Serial.println(i);
        }
        break;
    case 'z':
        wdt_enable(WDTO_15MS);
        for (;;) {
        }
    case 'l':
        digitalWrite(13, HIGH);
        delay(20);
        digitalWrite(13, LOW);
        break;
    default: break;
    }
}
