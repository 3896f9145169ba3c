/* The PWM signals of another controller, which the firmware may watch. */
#include "wave.h"

#include "pins.h"

#include <stdlib.h>

#define WAVES 2

struct wave {
	struct gen_mega *mega;
	struct pin pin;
	int level;
	uint32_t period, high; /* cycles */
};

struct waves {
	struct wave wave[WAVES];
	int count;
};

static avr_cycle_count_t wave_edge(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	struct wave *wave = parameter;
	int steady = !wave->high || wave->high >= wave->period;
	wave->level = steady ? wave->high != 0 : !wave->level;
	mega_drive(wave->mega, wave->pin, wave->level);
	return when + (steady ? wave->period : wave->level ? wave->high : wave->period - wave->high);
}

static int attach(struct gen_mega *mega)
{
	mega->waves = calloc(1, sizeof *mega->waves);
	return mega->waves ? 0 : -1;
}

static void close_waves(struct gen_mega *mega)
{
	free(mega->waves);
}

static void rearm(struct gen_mega *mega)
{
	for (int i = 0; i < mega->waves->count; i++)
		avr_cycle_timer_register(mega->avr, 1, wave_edge, &mega->waves->wave[i]);
}

const struct part mega_waves_part = {.attach = attach, .rearm = rearm, .close = close_waves};

int gen_mega_wave(struct gen_mega *mega, char port, uint8_t bit, uint32_t period, uint32_t high)
{
	struct pin pin = {port, bit};
	struct wave *wave = NULL;
	if (!mega_pin(mega, pin) || !period || high > period)
		return -1;
	for (int i = 0; i < mega->waves->count; i++)
		if (mega->waves->wave[i].pin.port == port && mega->waves->wave[i].pin.bit == bit)
			wave = &mega->waves->wave[i];
	if (!wave) {
		if (mega->waves->count == WAVES)
			return -1;
		wave = &mega->waves->wave[mega->waves->count++];
		*wave = (struct wave){.mega = mega, .pin = pin};
		avr_cycle_timer_register(mega->avr, 1, wave_edge, wave);
	}
	wave->period = period;
	wave->high = high;
	return 0;
}
