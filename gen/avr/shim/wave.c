/* The PWM signals of another controller, which the firmware may watch. */
#include "mega.h"

static avr_cycle_count_t wave_edge(avr_t *avr, avr_cycle_count_t when, void *parameter)
{
	(void)avr;
	struct wave *wave = parameter;
	int steady = !wave->high || wave->high >= wave->period;
	wave->level = steady ? wave->high != 0 : !wave->level;
	mega_drive(wave->mega, wave->pin, wave->level);
	return when + (steady ? wave->period : wave->level ? wave->high : wave->period - wave->high);
}

void mega_waves_rearm(struct gen_mega *mega)
{
	for (int i = 0; i < mega->wave_count; i++)
		avr_cycle_timer_register(mega->avr, 1, wave_edge, &mega->waves[i]);
}

/* A signal that is high for some cycles of every period; 0: low for good, period: high for good. A new share begins
 * with the next edge. */
int gen_mega_wave(struct gen_mega *mega, char port, uint8_t bit, uint32_t period, uint32_t high)
{
	struct pin pin = {port, bit};
	struct wave *wave = NULL;
	if (!mega_pin(mega, pin) || !period || high > period)
		return -1;
	for (int i = 0; i < mega->wave_count; i++)
		if (mega->waves[i].pin.port == port && mega->waves[i].pin.bit == bit)
			wave = &mega->waves[i];
	if (!wave) {
		if (mega->wave_count == WAVES)
			return -1;
		wave = &mega->waves[mega->wave_count++];
		*wave = (struct wave){.mega = mega, .pin = pin};
		avr_cycle_timer_register(mega->avr, 1, wave_edge, wave);
	}
	wave->period = period;
	wave->high = high;
	return 0;
}
