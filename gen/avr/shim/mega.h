/* What the parts of the shim share: the one handle, and how a part stops a run or leaves a message.
 *
 * The shim is a small C face on libsimavr for shim.py: plain integers and buffers. No struct of simavr crosses that
 * border, so Python maps nothing of it. Nothing here prints or exits: a fault leaves a message in the handle and a
 * status that Python turns into an exception.
 *
 *   mega.c     opening, resetting, running, stopping, memory
 *   uart.c     UART0's outer side
 *   mailbox.c  records in and out of a harness (see ../mailbox.h)
 *   pins.c     levels put on pins, levels seen on pins
 *   max6675.c  thermocouple converters on bit-banged pins
 *   encoder.c  an encoder's pulses
 *   counter.c  Timer 5 counting them
 *   wave.c     PWM signals from another controller
 *   eeprom.c   the EEPROM's contents, its write time, a write that is cut short
 *
 * Names: gen_mega_* is the face, mega_* is shared inside, the rest is file-local. A reset drops all of simavr's cycle
 * timers: a part that uses one arms it again in its mega_*_rearm(). New functions of the face raise GEN_MEGA_ABI.
 */
#ifndef GEN_MEGA_H
#define GEN_MEGA_H

#include <simavr/sim_avr.h>
#include <simavr/avr_ioport.h>

#include <stddef.h>
#include <stdint.h>

#define GEN_MEGA_ABI 3
#define FREQUENCY_HZ 16000000u
#define MESSAGE_SIZE 256
#define PATTERN_SIZE 256
#define CHIPS 32
#define PROBES 16
#define WAVES 2
#define PORTS 12 /* A..L without I */

/* Why a run ended; simulator.py holds the same numbers. */
enum gen_stop {
	STOP_LIMIT = 0,   /* the cycle limit */
	STOP_PATTERN = 1, /* the awaited bytes left UART0 */
	STOP_ENDED = 2,   /* the firmware executed cli; sleep */
	STOP_CRASHED = 3, /* illegal opcode, address or jump: see the message */
	STOP_RECORDS = 4, /* every record is done */
	STOP_PROTOCOL = 5, /* the firmware broke the mailbox protocol: see the message */
	STOP_PLACE = 6    /* the program counter reached the awaited place */
};

struct records {
	const uint8_t *in;
	uint8_t *out;
	uint32_t *cycles;
	uint32_t in_size, out_size, count, next;
	uint16_t in_address, out_address;
	int active;   /* a run_records call is under way */
	int stepping; /* between mark 1 and mark 2 */
	avr_cycle_count_t start;
};

struct uart {
	avr_irq_t *input;
	int full; /* simavr said XOFF */
	uint8_t *captured;
	size_t captured_length, captured_capacity, taken;
	uint8_t *queue;
	size_t queue_length, queue_head;
	uint64_t byte_cycles; /* spacing of the bytes that go in */
	uint8_t pattern[PATTERN_SIZE];
	size_t pattern_length;
	size_t seen_from; /* the pattern may not reach back before this place in captured */
};

/* A pin of the chip: port 'A'..'L', bit 0..7. */
struct pin {
	char port;
	uint8_t bit;
};


struct probe {
	struct gen_mega *mega;
	avr_cycle_count_t *cycles;
	uint8_t *levels;
	size_t length, capacity;
};

/* A MAX6675: see max6675.c. */
struct chip {
	struct gen_mega *mega;
	struct pin cs, so, sck;
	int selected, clock;
	uint16_t now, before;       /* what a conversion gives at present, and what it gave before the last change */
	uint16_t held;              /* the last finished conversion */
	uint16_t shifting;          /* what is left to clock out, most significant bit first */
	avr_cycle_count_t changed, high_since, conversion;
	uint32_t reads, early, clashes;
};

/* An encoder: see encoder.c. */
struct encoder {
	struct pin pin;
	int attached, level, counted;
	struct avr_int_vector_t *vector; /* of the pin's external interrupt; NULL when it has none */
	const struct avr_regbit_t *sense; /* its ISC bits, both */
	avr_cycle_count_t start, span, batch; /* batch = 0: every edge at its own time */
	uint32_t count, edges;
	uint64_t risen, owed; /* owed: interrupts of a batch that are still to be raised */
};

/* Timer 5 on its external clock: see counter.c. */
struct counter {
	avr_io_read_t read; /* simavr's own handlers */
	avr_io_write_t count_write, clock_write;
	void *read_parameter, *count_parameter, *clock_parameter;
	uint16_t value;  /* the count when risen pulses stood at since */
	uint64_t since;
};

struct wave {
	struct gen_mega *mega;
	struct pin pin;
	int level;
	uint32_t period, high; /* cycles */
};

struct eeprom {
	avr_io_write_t write; /* simavr's own handler of EECR */
	void *write_parameter;
	uint8_t *bytes;
	uint16_t size, address;
	uint8_t old, wanted;
	int busy;
	avr_cycle_count_t started, duration;
	uint32_t writes, refused;
};

struct gen_mega {
	avr_t *avr;
	char message[MESSAGE_SIZE];
	int stop;        /* an enum gen_stop, valid when stopped is set */
	int stopped;     /* a hook asked the run to end */
	int crashed;     /* for good */
	int resume;      /* simavr's state before the stop */
	uint32_t resets; /* since the first one */
	int timers_lost; /* a reset dropped the cycle timers */
	avr_cycle_count_t limit;
	avr_cycle_count_t asleep; /* cycles slept */
	avr_cycle_count_t woke, longest_awake;
	void (*core_reset)(avr_t *);
	struct records records;
	struct uart uart;
	avr_ioport_t *ports[PORTS]; /* simavr's own, by letter; NULL where there is none */
	struct probe probes[PROBES];
	struct chip chips[CHIPS];
	int probe_count, chip_count;
	struct encoder encoder;
	struct counter counter;
	struct wave waves[WAVES];
	int wave_count;
	struct eeprom eeprom;
};

void mega_stop(struct gen_mega *mega, int reason);
void mega_note(struct gen_mega *mega, const char *format, ...) __attribute__((format(printf, 2, 3)));
int mega_run(struct gen_mega *mega, uint64_t limit);

void mega_uart_attach(struct gen_mega *mega);
void mega_uart_rearm(struct gen_mega *mega);
void mega_uart_close(struct gen_mega *mega);

void mega_mailbox_attach(struct gen_mega *mega);

avr_irq_t *mega_pin(const struct gen_mega *mega, struct pin pin); /* NULL when there is no such pin */
void mega_drive(struct gen_mega *mega, struct pin pin, int level); /* level 0 or 1; -1 lets go */
void mega_pins_attach(struct gen_mega *mega);
void mega_pins_reset(struct gen_mega *mega);
void mega_pins_close(struct gen_mega *mega);

void mega_chips_reset(struct gen_mega *mega, int power_lost);

void mega_encoder_rearm(struct gen_mega *mega);
uint64_t mega_encoder_risen(const struct gen_mega *mega);
int mega_counter_attach(struct gen_mega *mega, struct pin pin);
void mega_counter_reset(struct gen_mega *mega);
void mega_waves_rearm(struct gen_mega *mega);

void mega_eeprom_attach(struct gen_mega *mega);
void mega_eeprom_rearm(struct gen_mega *mega);
void mega_eeprom_cut(struct gen_mega *mega, uint32_t seed);

#endif
