"""What loggers call quantities beside temperatures, in English, German, French, Italian, Spanish, Portuguese and Dutch.

Each is a part of a regular expression, of whole words. A word that means another thing in another language stands only
where its unit, or that it stands alone, tells them apart.
"""

from __future__ import annotations

TIME = (
    r"(?:temps|tempo|tiempo|tijd)"
    r"(?:[ _-](?:[ée]coul[ée]|relatif|total|trascorso|relativo|decorrido|transcurrido|verstreken))?|"
    r"heure|horodatage|ora|hora|fecha|tijdstip"
)
"""Alone only: `core temps` are temperatures, and Italian `data`, a date, is anything in English."""
TIME_ONLY = r"tempo|tempi|tempos"
"""What looks like a temperature, and is none."""
DUTY = (
    r"duty|duty.?cycle|dutycycle|tastgrad|tastverh(?:ä|ae)ltnis|rapport.cyclique|mli|ciclo.de.trabajo|ciclo.de.trabalho|"
    r"ciclo.di.lavoro|arbeitszyklus|einschaltdauer|puls.?pausen?.?verh(?:ä|ae)ltnis"
)
COMMAND = (
    r"throttle|command|commanded|cmd|stellgr(?:ö|oe)(?:ß|ss)e|stellwert|stellgrad|stellsignal|ansteuerung|aussteuerung|"
    r"kommando|gaspedal|commande|acc[ée]l[ée]rateur|comando|acceleratore|mando|acelerador|aansturing|sturing|stuursignaal"
)
"""What a controller gives a motor."""
OUTPUT = r"output|control|ausgang|sortie|uscita|salida|sa[íi]da|uitgang"
"""The same, or a side of a machine: a bearing's."""
WANTED = (
    r"set|setpoint|soll[a-zäöüß]*|target|ziel|zielwert|vorgabe|f(?:ü|ue)hrungsgr(?:ö|oe)(?:ß|ss)e|consigne|cible|"
    r"riferimento|consigna|refer[êe]ncia|gewenst|streefwaarde"
)
"""What it shall reach."""
SETPOINT = r"setpoint|sollwert|consigne|consigna"
"""Such a value of what drives a motor, where nothing else does."""
CURRENT = r"current|currents|strom|courant|corrente|corriente|stroom|motorstrom"
POWER = r"power|leistung|puissance|potenza|potencia|potência|vermogen|heizleistung|motorleistung"
SPEED = (
    r"speed|rpm|velocity|drehzahl|motordrehzahl|geschwindigkeit|umdrehungen|vitesse|velocit[àa]|velocidad|velocidade|"
    r"snelheid|toerental|toeren|giri"
)
VOLTAGE = r"voltage|spannung|tensione|tensión|tens[ãa]o|motorspannung"
VOLTAGE_IN_VOLTS = r"tension|spanning"
"""French and Dutch for voltage, but in English a belt's, and a width: told apart by the unit."""
HEAT = r"heat|heater\d*|heating|heizung|chauffage|riscaldamento|riscaldatore|calefacci[óo]n|aquecimento|verwarming"
OTHER = (
    r"couple|coppia|par|koppel|torque|drehmoment|moment|position|posizione|posici[óo]n|posi[çc][ãa]o|positie|drehwinkel|"
    r"pression|pressione|presi[óo]n|press[ãa]o|luftdruck|r[ée]gime|r[ée]gimen|fr[ée]quence|frequenz|frequenza|frecuencia|"
    r"[ée]nergie|energ[íi]a|d[ée]bit|durchfluss|portata|caudal|debiet|d[ée]formation|schwingung|vibrations?|"
    r"humidit[ée]|feuchtigkeit|luftfeuchte|luftfeuchtigkeit|umidit[àa]|humedad|umidade|vochtigheid"
)
"""Of a part, and no temperature."""
MACHINE_PARTS = (
    r"gear(?:box)?|getriebe|r[ée]ducteur|riduttore|reductor|redutor|versnellingsbak|esc|controller|regler|driver|"
    r"inverter|umrichter|wechselrichter|onduleur|mosfets?|mos|fets?|igbts?|transistors?|(?:h[ _-]?)?bridge|"
    r"heat[ _-]?sink|k(?:ü|ue)hlk(?:ö|oe)rper|dissipateur|dissipatore|disipador|dissipador|koellichaam|"
    r"battery|batterie|akku|batteria|bater[íi]a|accu|cells?|pack|cab|cabin|cabine|pcb|board|platine|mcu|cpu|chip|"
    r"spindle|spindel(?:kasten)?|broche|mandrino|husillo|flange|flansch|bride|flangia|brida|"
    r"cover|deckel|lid|frame|rahmen|chassis|foot|fu(?:ß|ss)|base|plate|platte|block|wall|shell|body|"
    r"end[ _-]?cap|end[ _-]?shield|lagerschild|commutator|kommutator|kollektor|collector|brake|bremse|clutch|kupplung|"
    r"pulley|hub|nabe|engine|cylinder|zylinder|oil|öl|oel|water|wasser|transformer|trafo|seal|dichtung|hot[ _-]?end|"
    r"nozzle|bed"
)
"""Of a machine, and of more than its temperature: a battery's volts, a controller's output."""
