"""What columns are by their names, and the names that they get in a run file."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection

from gen.coefficients.names import MAX_LENGTH, name_fault
from gen.importing.guessing import languages

_SPECIAL = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss", "%": "percent"})


_POWER = re.compile(r"^@|(?<=[A-Za-z0-9])@$")
"""A printer's mark of what a heater is given: `@`, `B@`, `@0`."""


def _words(text: str) -> re.Pattern[str]:
    return re.compile(rf"(?:^|[^a-z])(?:{text})(?:[^a-z]|$)", re.IGNORECASE)


TIME = re.compile(
    rf"t|ts|s|[uµμ]s|ns|sek|x_value|tout|stats|timeframe|m?jd|{languages.TIME}|"
    r"(?:.*[^a-z])?(?:time|times|zeit|uhrzeit|timestamp|zeitstempel|datum|date|datetime|elapsed|epoch|unix|gps|ntp|clock|"
    r"millis|micros|seconds?|secs?|ms|minutes?|minuten|hours?|stunden|sekunden)(?:[^a-z].*)?|.*time|.*zeit",
)
OF_DAY = re.compile(
    r"(?:local |lokale )?(?:uhrzeit|uhr|clock|clock time|time of day|wall ?time|tageszeit|heure|hora|ora|orario|"
    r"hor[áa]rio|tijdstip|hh:mm|time \(?hh:mm\)?)"
)
"""A time of day by its name, where minutes since something began would look the same."""
DAY_FIRST = re.compile(
    r"datum|zeit|uhrzeit|zeitstempel|fecha|hora|data|ora|heure|horodatage|tijd|tijdstip", re.IGNORECASE
)
"""Names of dates and times where the day is written first: `date` is not one."""
PWM = _words(r"pwm\d*")
NO_DRIVE = _words(
    r"freq|frequency|frequenz|fr[ée]quence|frequenza|frecuencia|[km]?hz|period|periode|p[ée]riode|resolution|pin"
)
"""What a PWM has beside its duty: `pwm_freq`."""
COOLS = _words(
    r"fans?|blowers?|cooler|cooling|pump|l(?:ü|ue)fter|gebl(?:ä|ae)se|k(?:ü|ue)hlung|ventilat\w+|ventola|ventoinha"
)
"""What is driven to cool: its duty is what heats only where there is nothing else."""
HEATS = _words(f"{languages.HEAT}|{languages.POWER}")
DUTY = _words(languages.DUTY)
DRIVES = _words(
    f"{languages.COMMAND}|{languages.OUTPUT}|{languages.POWER}|{languages.CURRENT}|{languages.SPEED}|{languages.HEAT}|"
    f"{languages.SETPOINT}|"
    r"gas|drive|antrieb|azionamento|entra[îi]nement|accionamiento|acionamento|aandrijving|load|pid|ssr|utili[sz]ation|"
    r"i|p|q\d*|@"
)
FREQUENCY = _words(
    r"\w*frequenz|\w*frequency|freq|fr[ée]quence|frequenza|frecuencia|frequ[êe]ncia|frequentie|hz|f[ _-]?out"
)
"""What an inverter gives a motor: how fast it is to turn."""
NO_INVERTER = _words(
    r"pwm|mains|grid|line|netz\w*|sampl\w+|abtast\w*|resonan\w+|natural|eigen\w*|vibration|schwing\w*|clock|cpu|core|"
    r"carrier|switching|takt\w*|[kmg]hz"
)
"""What has another frequency."""
STORED = _words(
    r"%?rh|hum|humidity|moisture|soc|battery|batt?|akku|charge|level|f(?:ü|ue)llstand|fuel|tank|quality|valid\w*|signal|"
    r"cpu|mem|memory|ram|disk|efficiency|wirkungsgrad|error|fehler|progress|slip|schlupf|feuchte"
)
"""What is told in percent, and drives nothing."""
SPEED_OF = _words(languages.SPEED)
CURRENT_OF = _words(f"{languages.CURRENT}|i|amps?")
SIGN = _words(
    r"dir|direction|richtung|drehrichtung|sign|sens.de.rotation|senso.di.rotazione|sentido(?:.de.giro)?|draairichting|"
    r"rotation|drehsinn"
)
BACKWARDS = _words(r"reversed?|backwards?|rev|r(?:ü|ue)ckw(?:ä|ae)rts")
"""A flag that is 1 where a motor turns backwards."""
ENABLES = _words(r"enabled?|en|output|relay|relais|freigabe|active|switch|on")
"""What switches a motor beside its PWM."""
NO_SIGN = _words(r"valve|ventil|wind|flow|damper|klappe|door|air|fans?|pump|conveyor|stage|axis|trend|scan|sort")
"""Whose direction is not the motor's."""
NO_TEMPERATURE = re.compile(languages.TIME_ONLY, re.IGNORECASE)
RUNS = re.compile(
    r"(?:run|runs|run.?id|run.?name|test|test.?id|experiment|session|trial|profile.?id|versuch|lauf|file)"
)
SERIES = re.compile(
    r"sensor|sensor.?name|sensor.?id|channel|kanal|signal|variable|field|_field|tag|tag.?name|entity.?id|metric|series|topic|"
    r"tags|node|node.?id|probe|item|parameter|quantity|id|channel.?(?:id|no|nr|number)|var.?name|messstelle|messgr(?:ö|oe)(?:ß|ss)e|capteur|sensore"
)
DEVICES = re.compile(
    r"(?:unit|device|dev|index|instance|motor|slave|station|addr|address|drive|axis|gpu|board|module|esc|machine|modul|"
    r"ger(?:ä|ae)t|motoren|adresse|achse|antrieb|moteur|motore)s?"
    r"(?:[ _-]?(?:id|no|nr|number|index|address|addr|adr|idx))?"
)
"""What columns are called that say by numbers whose readings a row holds, where these come by turns."""
_SAYS_AMBIENT = (
    r"amb|ambient|ambiance|t_?amb|surroundings?|(?:t_?)?umg|umgebung|umgebungstemp(?:eratur)?|umgebungsluft|ambiante?s?|ambiente|"
    r"ambientale?|omgeving|omgevingstemperatuur|omgevingslucht"
)
_SAYS_ROOM = (
    r"(?:t_?)?room|(?:t_?)?raum|raumtemp(?:eratur)?|raumluft|raumlufttemp(?:eratur)?|zimmer|zimmertemp(?:eratur)?|"
    r"halle|hallentemp(?:eratur)?|salle|pièce|"
    r"stanza|sala|habitaci[óo]n|kamer|kamertemperatuur|ruimte|ruimtetemperatuur|"
    r"(?:t_?)?lab|labo|labor(?:temp(?:eratur)?)?|laboratory|laboratorium|laboratoire|laborat[óo]rio|workshop|shop|"
    r"werkstatt(?:temp(?:eratur)?)?|werkhalle|hangar|garage|keller(?:temp(?:eratur)?)?|cellar|basement|office|"
    r"b(?:ü|ue)ro|indoors?|atelier|officina|taller|oficina|werkplaats|weather|wetter"
)
_SAYS_AIR = (
    r"outside|outdoors?|temp[ ._]?out|out[ ._]?temp|(?:t_?)?air|env|environment|"
    r"luft|lufttemp(?:eratur)?|au(?:ß|ss)en|au(?:ß|ss)entemp(?:eratur)?|"
    r"au(?:ß|ss)enluft|"
    r"ext[ée]rieure?|aria|estern[oa]|aire|exterior|do ar|lucht|luchttemperatuur|buiten|buitentemperatuur|buitenlucht"
)
AMBIENTS = tuple(map(_words, (_SAYS_AMBIENT, _SAYS_ROOM, _SAYS_AIR)))
"""What says the ambient: outright, by the room, and by words that stand beside other things, too."""
_SAYS_ANY = "|".join((_SAYS_AMBIENT, _SAYS_ROOM, _SAYS_AIR))
AMBIENT = _words(_SAYS_ANY)
HALL = _words(r"hall(?!.*(?:sensor|effect|state|pos))")
"""A room where its column is in degrees; else a sensor of magnets."""
RISE = _words(
    rf"(?:over|above|minus|(?:ü|ue)ber|gegen(?:ü|ue)ber|sur|sopra|sobre|boven)[ _-]+(?:{_SAYS_ANY})|rise|minus|"
    r"(?:ü|ue)bertemperatur|erw(?:ä|ae)rmung|[ée]chauffement|sovratemperatura|sobretemperatura|sobreelevaci[óo]n|"
    r"sobreeleva[çc][ãa]o|overtemperatuur|[Δ∆]\s?(?:t|temp|temperature?)?"
)
"""Above the ambient: `Winding over ambient`."""
MOIST = _words(
    r"dew.?p(?:oin)?t|taupunkt|point de ros[ée]e|punto di rugiada|punto de roc[íi]o|ponto de orvalho|dauwpunt|"
    r"wet.?bulb|feuchtkugel|heat.?index|feels.?like"
)
"""Told in degrees, of moist air, and the temperature of nothing."""
NEUTRAL = re.compile(
    r"t|tc|th|temps?|temp[ée]ratures?|temperatur(?:en)?|temperatura|temperatuur|thermo\w*|ntc|pt\d*|ds18\w*|sensor|probe|sonde|sonda|"
    r"f(?:ü|ue)hler|channel|kanal|ch|cold|junction|of|the|in|from|for|de|du|des|la|le|l|d|di|del|della|dell|do|da|der|die|das|van|"
    r"degrees?|deg|celsius|measured|meas|mess|messwert|actual|ist|value|last|avg|average|mean|mittel|min|max|[a-z]?\d*",
    re.IGNORECASE,
)
"""What stands beside such a word and changes nothing."""
WANTED = _words(rf"{languages.WANTED}|limit|threshold|grenze|model|estimated?|predicted")
ASKED = _words(r"goal|wanted|desired|demand(?:ed)?|request(?:ed)?|req|aim|sp|sv|cmd|command(?:ed)?")
"""What a temperature shall reach, where another quantity of that name is what a motor is told."""
BOUND = _words(
    r"limits?|max|maximum|min|minimum|alarms?|alerts?|warn|warning|trip|shut[ -]?(?:down|off)|cut[ -]?(?:off|out)|"
    r"crit|critical|lcrit|hyst|slow[ -]?down|throttling|emergency|threshold|grenze|"
    r"grenzwert|schwelle|limite|soglia|umbral|limiar|grens|rated|nominal|allowed|zul(?:ä|ae)ssig|hi|high"
)
"""What a part may have, where it is the same in all rows: `winding_max_C`."""
EXTREME = _words(r"(?:max|maximum|min|minimum|hi|high)(?! operat)")
"""What the largest of several readings is called as well as a limit."""
FLAG = _words(
    r"open|opened|fault|faults|fehler|error|errors|flag|flags|alarm|alarms|alert|status|state|ok|valid|invalid|enabled?|active|"
    r"connected|missing|code|id|nr|counts?|counter|index|mode|type"
)
"""What a sensor says beside its temperature: `Thermocouple open`, `temp_fault`."""
DIFFERENCE = _words(
    r"distance|difference|diff|differenz|delta|d[ _]?t|deviation|abweichung|abstand|gradient|slope|rate|change|drift|"
    r"offset"
)
"""In a unit of temperature, and none: `Distance to TjMAX [°C]`."""
OTHER = _words(
    r"current|currents|strom|amps?|amperes?|voltage|spannung|volts?|speed|drehzahl|rpm|erpm|velocity|omega|power|leistung|watts?|"
    r"energy|torque|drehmoment|moment|force|thrust|load|last|position|pos|angle|winkel|encoder|tacho(?:meter)?|clock|freq|"
    r"frequency|usage|utili[sz]ation|duty|pwm|throttle|cmd|command|on|off|enable|pressure|druck|flow|fan|vibration|vib|accel|"
    r"acceleration|gyro|flux|field|noise|level|resistance|ohms?|inductance|charge|soc|capacity|efficiency|hours|time|age|"
    r"humidity|feuchte|distance|weight|mass|pole|poles|kv|kp|ki|kd|vel|iq|uq|energie|odo|odometer|mileage|"
    f"{languages.OTHER}|{languages.COMMAND}|{languages.CURRENT}|{languages.POWER}|{languages.SPEED}|{languages.VOLTAGE}|"
    f"{languages.VOLTAGE_IN_VOLTS}|{languages.DUTY}"
)
"""Another quantity of a part: `motor_torque`, `Core 0 Clock`."""
WHERE = _words(
    r"ends?|front|rear|back|left|right|upper|lower|inner|outer|top|bottom|middle|centre|center|drive|side|de|nde|hot|cold|spot|"
    r"tip|slot|head|phase|ch\d+|ai\d+|avg|average|mean|mittel|max|min|vorn|vorne|hinten|links|rechts|oben|unten|innen|aussen|au(?:ß|ss)en|"
    r"nut|kopf|wickelkopf|present|actual|[a-z]|\d+|measured|meas|mess|ist|degrees?|sensor|probe|f(?:ü|ue)hler"
)
"""Words that say which part, or where on it, and not what was measured there."""
OTHER_UNIT = re.compile(
    r"[kMG]?Hz|[kKMGT]i?B(?:/s)?|[kMG]?bit(?:/s)?|[kM]?Pa|hPa|bar|mbar|psi|m?m/s\^?2?|m/s²|mm|cm|m|km/h|g|kg|N|mNm|l/min|m?Ah|[km]?Wh|"
    r"k?Ohm|k?Ω|lx|ppm|x|T/s|GT/s|Yes/No|on/off|0/1|bool",
    re.IGNORECASE,
)
"""Units in brackets that nothing here converts, but that are none of a temperature."""
THERMAL = re.compile(
    r".*(?:temp|th?ermo|°).*|tc\d*|t\d+|t_.*|ntc\d*.*|pt\d{3,4}.*|ds18.*|max6675.*|max31855.*|.*[^a-z]t\d*",
    re.IGNORECASE,
)
RESISTOR = _words(r"ntc\d*|thermistor\w*|rtd\d*")
"""What falls, or is told in ohms, where nobody converted it."""
SYMBOL = re.compile(
    r"T(?!im|ic|ac|or|hr|es|ot|ar|en|ur|ri|yp|rq|q|au|ag|as|og|ra|ab|op|ol|ok|wist|humb|on$|off|[sidnxyz]$)[A-Za-z]{1,4}\d*"
)
"""A temperature as formulas have it: `Tw`, `Tmot`, `TG`; no torque, throttle, time, total, target, tension."""
TELLS_UNIT = re.compile(
    r"(?:(?:temp|temps|temperatures?|temperatur|temp[ée]rature|temperatura|deg)[ _.-]?)?"
    r"(?:units?|uom|scale|einheit|unit[ée]|unit[àa]|unidad|eenheid)(?:[ _-]?\d+)?",
    re.IGNORECASE,
)
"""What says a unit in all rows: `temperature_unit`."""
PARTS = _words(
    r"winding|windings|wicklung|stator|rotor|bearing|lager|casing|case|housing|geh(?:ä|ae)use|coil|spule|brush|brushes|"
    r"b(?:ü|ue)rste|b(?:ü|ue)rsten|magnet|magnets|kohle|kohlen|shaft|welle|core|yoke|tooth|motor|surface|coolant|pm|endbell|"
    r"air.?gap|luftspalt|entrefer|traferro|entrehierro|entreferro|luchtspleet"
)
MACHINE_PARTS = _words(languages.MACHINE_PARTS)
"""Parts whose readings are temperatures only where they begin and move as such."""
CELLS = _words(r"battery|batterie|akku|batteria|bater[íi]a|accu|cells?|pack")
"""What is told in volts rather than in degrees, where it moves little."""
_OF = r"(?:(?:motor|mot|dc|bus|bat|batt|battery|supply|shaft|versorgungs?)[ _-]?)?"
_OF_BEHIND = r"(?:[ _-]?(?:(?:del?|du|d[oa]|di|van)[ _-])?(?:motor|mot|dc|bat|in|moteur|motore))?"


def _alone(text: str) -> re.Pattern[str]:
    return re.compile(rf"{_OF}(?:{text}){_OF_BEHIND}", re.IGNORECASE)


CURRENT = _alone(rf"i|ia|idc|{languages.CURRENT}|amps?|amperage|intensit[ée]|intensidad")
VOLTAGE = _alone(rf"u|v|vbat|ubat|vdc|vin|{languages.VOLTAGE}|volts?|supply")
VOLTAGE_IN_VOLTS = _alone(languages.VOLTAGE_IN_VOLTS)
SPEED = _alone(rf"omega|n|{languages.SPEED}|r[ée]gime|r[ée]gimen")


CHARGE = _alone(
    r"(?:total |used |net )?(?:charge|ladung|capacity|capacitance|kapazit(?:ä|ae)t|capacit[ée]|carga|carica)"
    r"(?: used| total)?"
)
"""What is told in C and F, too: coulomb and farad."""
CHARGED = _words(r"(?:milli)?(?:amp|amp[eè]re|watt|kilowatt)s?[ _-]?hours?")
"""No hours."""
NUMBERED = re.compile(r"(?:field|ch|channel|kanal|col|column|spalte|value|wert|var|ai|input)[ _-]?\d+", re.IGNORECASE)
"""What a service or a logger calls its columns where nobody named them: `field2` is no magnet's."""
PLACE = _words(
    r"gps|gnss|lat|latitude|lon|lng|longitude|alt|altitude|elevation|h(?:ö|oe)he|heading|satellites?|rssi|snr"
)
"""Where a machine was, and how well it was heard."""
LATE = _words(
    r"received|recv|rx|upload(?:ed)?|arriv(?:ed|al)|insert(?:ed)?|ingest(?:ed|ion)?|stored|server|processed|exported"
)
"""When a reading came somewhere, beside when it was taken."""
OF_A_STEP = _words(r"steps?|schritt|laps?|segment|cycle")
"""A time that begins anew with each step of a programme, beside that of all of it."""
WORKED = _words(
    r"(?:operating|running|run|service)[ _-]?hours|hour ?meter|betriebsstunden|heures de marche|ore di funzionamento"
)
"""How long a machine has run in its life."""
BUSY = _words(r"(?:cpu|processor|buffer)[ _-]?time")
"""What a processor worked, or what waits in a queue, s: no time of a log."""


_TERMS = frozenset("pid")


def are_terms(name: str, beside: Collection[str]) -> bool:
    """Whether a name is one of a controller's terms `p`, `i` and `d`, which stand beside each other.

    Parameters
    ----------
    name
        A column's.
    beside
        All columns'.
    """
    ends = {other.casefold().rpartition(".")[2] for other in beside}
    return name.casefold().rpartition(".")[2] in _TERMS <= ends


def is_thermal(name: str) -> bool:
    """Whether a name may be that of a temperature, whatever its column holds.

    Parameters
    ----------
    name
        A column's.
    """
    base = apart(name)
    return bool(THERMAL.fullmatch(base) or PARTS.search(base))


def apart(text: str) -> str:
    """A name with its words apart where capitals begin them: `rTempAmbient`, `PWMDuty`.

    Parameters
    ----------
    text
        A column's name.
    """
    return re.sub(r"(?<=[a-zäöüß])(?=[A-ZÄÖÜ])|(?<=[A-Z])(?=[A-Z][a-zäöü])", " ", text)


_CARRIER = re.compile(
    r"(?:(?:_source|attributes|body|data|event|fields?|log|measurements?|message|msg|object|params|payload|properties|"
    r"readings?|record|result|samples?|sensors?|signals|state|status|telemetry|values?)\.)+(?=[A-Za-z_])",
    re.IGNORECASE,
)


def carried(name: str) -> str:
    """A name without the objects of a message that it came in, which say nothing of it: `data.winding.value`, `T.1`.

    Parameters
    ----------
    name
        A column's name, inner objects behind dots.
    """
    carrier = _CARRIER.match(name)
    rest = name[carrier.end() :] if carrier else name
    plain = re.sub(r"(?i)(?<=[^.])\.(?:value|val|reading)$", "", rest)
    plain = re.sub(r"(?<=[^.])\.temp\d+_input$", " temp", plain)  # of `sensors -j`
    return re.sub(r"(?<=[A-Za-z])\.(?=\d+$)", "", plain)


def slug(text: str) -> str:
    """A name of ASCII letters, digits and underscores; empty where nothing is left.

    Parameters
    ----------
    text
        A column's name.
    """
    plain = unicodedata.normalize("NFKD", text.translate(_SPECIAL)).encode("ascii", "ignore").decode("ascii")
    return re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]+", "_", plain)).strip("_")


def component_name(base: str, taken: Collection[str]) -> str:
    """A component's name that a coefficient file can have, unlike those taken.

    Parameters
    ----------
    base
        The column's name without unit: ``Winding Temp`` becomes ``winding``, ``T_coil`` ``coil``, ``T1`` stays.
    taken
        Names that are.
    """
    name = slug(base)
    short = re.sub(r"(?i)(?:^|_)(?:temperatures?|temperatur|temps?)(?=_|$)", "_", name).strip("_")
    short = re.sub(r"^[Tt]_(?=[A-Za-z])", "", short)
    if short and short[0].isalpha():
        name = short
    if " " in base.strip() or re.fullmatch(r"[A-Z]?[a-z_]+", name):
        name = name.lower()
    if not name or not name[0].isalpha():
        name = f"sensor_{name}".rstrip("_")
    name = re.sub(r"_+", "_", name[:MAX_LENGTH]).rstrip("_")
    if name_fault(name):
        name = f"{name[: MAX_LENGTH - 5]}_part"
    return _fresh(name, taken)


def channel_name(base: str, unit: str, taken: Collection[str]) -> str:
    """A further channel's name, with its unit, unlike those taken.

    Parameters
    ----------
    base, unit
        Of the column; the unit may be empty.
    taken
        Names that are.
    """
    name = slug(_POWER.sub(" power ", base)) or "channel"
    name = name if name[0].isalpha() else f"channel_{name}"
    ending = slug(unit.replace("/", "_per_"))
    return _fresh(f"{name}_{ending}" if ending else name, taken)


def _fresh(name: str, taken: Collection[str]) -> str:
    if name not in taken:
        return name
    return next(f"{name}_{i}" for i in range(2, 10_000) if f"{name}_{i}" not in taken)
