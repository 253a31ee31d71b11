"""Slovak prose of the steps, terms as the textbook uses them."""

TEXTS = {
    "title": "Pohybové rovnice mechanizmu {scene} krok za krokom",
    "section.scene": "Mechanizmus",
    "section.positions": "Polohy",
    "section.velocities": "Rýchlosti",
    "section.energies": "Energie",
    "section.lagrangian": "Lagrangián",
    "section.equations": "Lagrangeove rovnice II. druhu",
    "section.coefficients": "Koeficienty a ich význam",
    "section.numbers": "V číslach",
    # tables
    "table.joint": "spojenie",
    "table.kind": "druh",
    "table.parent": "na člene",
    "table.child": "nesie člen",
    "table.coordinate": "súradnica",
    "table.symbol": "symbol",
    "table.meaning": "význam",
    "table.unit": "jednotka",
    "table.value": "hodnota",
    "table.coefficient": "koeficient",
    "table.why": "prečo",
    "table.where": "kde",
    "ground": "rám",
    # the mechanism
    "scene": "{scene} je otvorený mechanizmus (OM); počet pohyblivých členov je {bodies}, pohyblivosť {freedoms}.",
    "scene.reason": "Každý pohyblivý člen visí na jednom spojení, preto súradnice spojení určujú polohu všetkého.",
    "acting": "Okrem pohonov a tiaží pôsobí:",
    "acting.force": "sila popri pohone",
    "acting.damping": "viskózne tlmenie",
    "acting.motion": "predpísaný pohyb",
    "acting.coupling": "spriahnutie",
    "acting.follows": "spojenie {joint} nasleduje spojenie {leader}: jeho súradnica je {position}",
    "acting.joint": "spojenie {joint}",
    "acting.reason": "Súradnica s predpísaným pohybom sleduje svoj vzorec; jej pohon je to, čo to vyžaduje. Rovnice "
    "platia pre každý pohyb; čísla nižšie sú pre stav, ktorý je tam uvedený.",
    "picture.caption": "{scene}: súradnice, súradnicové systémy spojení, smer tiaže.",
    "notation": "Používame tieto symboly; bodka znamená deriváciu podľa času.",
    "notation.angle": "uhol v spojení {joint}",
    "notation.way": "posunutie v spojení {joint}",
    "notation.rate": "zovšeobecnená rýchlosť súradnice {q}",
    "notation.torque": "hnací moment v spojení {joint}",
    "notation.force": "hnacia sila v spojení {joint}",
    "notation.parameter": "parameter",
    "long": "{name} je dlhé, počet členov výrazu: {terms}",
    "long.short": "počet členov výrazu: {terms}",
    # positions and velocities
    "position.particle": "Hmotný bod {tag} člena {body} má v globálnom súradnicovom systéme polohu",
    "position.centre": "Ťažisko {tag} člena {body} má v globálnom súradnicovom systéme polohu",
    "position.origin": "Začiatok súradnicového systému člena {body} s indexom {tag} má v globálnom systéme polohu",
    "velocity": "Rýchlosť miesta {tag} je deriváciou jeho polohy.",
    "velocity.reason": "Derivácia súčinu a zloženej funkcie: deriváciou sínusu je kosínus krát derivácia celého uhla, "
    "deriváciou kosínusu je mínus sínus krát derivácia celého uhla, deriváciou posunutia je jeho rýchlosť. Parametre "
    "sú stále.",
    "velocity.term": "výraz",
    "velocity.rate": "jeho derivácia",
    "velocity.terms": "Derivácia po jednotlivých výrazoch",
    "velocity.rests": "Miesto {tag} je v pokoji.",
    "turning": "Člen {body} má túto uhlovú rýchlosť, vyjadrenú v jeho vlastných osiach.",
    "turning.reason": "Antisymetrická matica uhlovej rýchlosti je transponovaná matica smerových kosínusov krát jej "
    "derivácia. Vo vlastných osiach člena sú momenty zotrvačnosti stále.",
    # energies
    "square": "Druhá mocnina rýchlosti miesta {tag} je súčet druhých mocnín jej zložiek.",
    "square.out": "Po umocnení, keď všetko okrem sínusov a kosínusov vyjmeme pred zátvorky:",
    "square.fold": "Po umocnení, počet členov výrazu: {terms}",
    "square.result": "Po úprave:",
    "square.long": "Po umocnení by zaplnila strany; nižšie má kinetická energia svoj najjednoduchší tvar.",
    "identity.pythagoras": "Pretože sin² + cos² = 1:",
    "identity.addition": "Podľa súčtového vzorca cos(a − b) = cos a cos b + sin a sin b a jemu podobných:",
    "kinetic": "Kinetická energia hmotnosti {tag} člena {body}.",
    "spin": "Kinetická energia rotácie člena {body}.",
    "spin.reason": "Polovica momentov zotrvačnosti krát druhé mocniny uhlových rýchlostí okolo osí člena a deviačné "
    "momenty krát súčiny dvoch z nich.",
    "offset": "Začiatok súradnicového systému nie je v ťažisku člena {body}: pribudne zmiešaný člen.",
    "offset.reason": "Je to rýchlosť začiatku krát vektorový súčin uhlovej rýchlosti a statického momentu.",
    "rotor": "Otáča sa aj rotor v spojení {joint}.",
    "potential": "Potenciálna energia hmotnosti {tag} člena {body} v gravitačnom poli.",
    "potential.reason": "Práca tiaže na ceste odtiaľto do začiatku: mínus skalárny súčin tiaže a polohového vektora, "
    "teda tiaž krát výška.",
    "springs": "Pružiny hromadia energiu.",
    "springs.reason": "Energia je sila sčítaná po dráhe od voľnej dĺžky.",
    "energies": "Celková kinetická a potenciálna energia.",
    "lagrangian": "Lagrangián je rozdiel kinetickej a potenciálnej energie.",
    # equations
    "momentum": "Najprv {slope}.",
    "momentum.reason": "V kinetickej energii sa uplatnia len výrazy s {rate}: druhá mocnina dá dvojnásobok svojho "
    "koeficienta krát {rate}, súčin dá druhú z rýchlostí. Potenciálna energia rýchlosti neobsahuje.",
    "rate": "Jej derivácia podľa času, {rate}.",
    "rate.reason": "Derivácia súčinu a zloženej funkcie: každý výraz dá jeden so zrýchlením namiesto rýchlosti a jeden "
    "za každú súradnicu, od ktorej závisí jeho koeficient, krát rýchlosť tejto súradnice.",
    "rate.term": "výraz",
    "rate.from": "cez",
    "rate.gives": "dá",
    "rate.fold": "Ktorý výraz pochádza od ktorej rýchlosti",
    "slope": "Potom {slope}.",
    "slope.reason": "Rýchlosti držíme stále; derivuje sa to, čo závisí od {q}.",
    "slope.absent": "Kinetická energia od {q} nezávisí; závisieť môže len potenciálna.",
    "equation": "Lagrangeova rovnica {left} = {right}, usporiadaná podľa zrýchlení a rýchlostí, má tvar",
    "equation.reason": "Toto musí dodať pohon súradnice {q}.",
    "equation.passive": "Súradnicu {q} nič nepoháňa; súčet týchto výrazov sa rovná tomu, čo tam ešte pôsobí.",
    "equation.named": "Dlhé koeficienty sú uvedené označením; vypísané sú nižšie.",
    # coefficients
    "coefficients.k_z": "Koeficienty pri zrýchleniach:",
    "coefficients.k_C": "Koeficienty pri súčinoch dvoch rýchlostí:",
    "coefficients.k_D": "Koeficienty pri druhých mocninách rýchlostí:",
    "coefficients.k_G": "Príspevok tiaže:",
    "coefficients.k_E": "Príspevok pružín:",
    "coefficients.zero": "Identicky nulové: {names}.",
    "check.title": "Kontrola",
    "check.equal": "{first} − {second} = 0 pre všetky polohy a parametre: oboje bolo odvodené a v rozdiele nezostal "
    "žiaden výraz.",
    "inertia": "{name} je moment zotrvačnosti všetkého za osou spojenia {joint} k tejto osi: {tags}.",
    "inertia.reason": "Ak sa ostatné spojenia zaistia, všetko za osou je jedno tuhé teleso, ktoré sa okolo nej otáča. "
    "Jeho moment zotrvačnosti tu počítame len zo vzdialeností, bez energie.",
    "inertia.torque": "Samotné zrýchlenie {rate} vyžaduje",
    "mass": "{name} je hmotnosť, ktorou pohybuje spojenie {joint}: {tags}.",
    "mass.reason": "Ak sa ostatné spojenia zaistia, všetko za posuvným spojením je jedno tuhé teleso, ktoré sa posúva.",
    "induced": "{name} je reakčný účinok, ktorý v osi spojenia {joint} indukuje zrýchlenie {rate}.",
    "induced.how": "V pokoji pri {rate} = 1 pôsobí na každú hmotnosť zotrvačná sila, mínus hmotnosť krát zrýchlenie. "
    "Momenty týchto síl k prvej osi (pri posuve zložky v jej smere) dajú v súčte mínus",
    "induced.split": "Ich moment k prvej osi je súčet momentu k druhej osi a momentu ich výslednice umiestnenej v "
    "druhej osi:",
    "induced.twin": "a oba koeficienty sú tou istou funkciou:",
    "induced.reason": "Kinetická energia obsahuje jeden výraz so súčinom oboch rýchlostí. Derivovaný podľa jednej a "
    "potom podľa druhej rýchlosti, v ľubovoľnom poradí, dá ten istý koeficient.",
    "induced.none": "{name} je nula: sily, ktorými hmotnosti odporujú zrýchleniu {rate}, nemajú moment k osi spojenia "
    "{joint}.",
    "induced.none.slide": "{name} je nula: sily, ktorými hmotnosti odporujú zrýchleniu {rate}, nemajú zložku v smere "
    "spojenia {joint}.",
    "meaning.k_D": "Druhé mocniny rýchlostí: dostredivé zrýchlenie a sila, ktorú vyžaduje.",
    "meaning.k_D.reason": "Hmotný bod na kružnici má dostredivé zrýchlenie. Reakčná odstredivá sila má k inej osi "
    "moment, len ak jej nositeľka s touto osou nie je rôznobežná ani rovnobežná, a zložku v smere posuvu, len ak naň "
    "nie je kolmá.",
    "meaning.k_C": "Súčiny dvoch rôznych rýchlostí: Coriolisovo zrýchlenie.",
    "meaning.k_C.reason": "Čo sa pohybuje vzhľadom na otáčajúci sa člen, má zrýchlenie rovné dvojnásobku vektorového "
    "súčinu uhlovej a relatívnej rýchlosti.",
    "meaning.others": "Spojenia s viacerými voľnosťami alebo také, ktoré iné spojenia nasledujú: {joints}. Ich "
    "koeficienty tu druhýkrát neodvodzujeme.",
    "k_D.acts": "{j} odtláča hmotnosti od osi {axis}; táto sila má moment k osi {i}",
    "k_D.acts.slide": "{j} odtláča hmotnosti od osi {axis}; táto sila má zložku v smere posuvu {i}",
    "k_D.own": "nositeľka odstredivej sily je s osou {i} rôznobežná",
    "k_D.apart": "{j} nepohybuje ničím, čo nesie spojenie {i}",
    "k_D.none": "hmotnosti, ktorými {j} otáča, ležia na osi {axis}: odstredivá sila nevzniká",
    "k_D.straight": "posuv je priamočiary: {j} samo nespôsobuje dostredivé zrýchlenie",
    "k_D.meets": "odstredivá sila od {j} nemá moment k osi {i}: jej nositeľka je s osou rôznobežná alebo rovnobežná",
    "k_D.meets.slide": "odstredivá sila od {j} je kolmá na posuv {i}",
    "k_D.cancel": "momenty odstredivých síl od {j} k osi {i} sa rušia",
    "k_D.cancel.slide": "zložky odstredivých síl od {j} v smere posuvu {i} sa rušia",
    "k_C.acts": "{j} unáša to, čo sa pohybuje s {k}: Coriolisova sila má moment k osi {i}",
    "k_C.acts.slide": "{j} unáša to, čo sa pohybuje s {k}: Coriolisova sila má zložku v smere posuvu {i}",
    "k_C.straight": "posuv neotáča to, čo unáša: {j} a {k} spolu nespôsobujú Coriolisovo zrýchlenie",
    "k_C.apart": "{j} a {k} spolu nepohybujú ničím, čo nesie spojenie {i}",
    "k_C.none": "{j} a {k} spolu neudeľujú žiadnej hmotnosti Coriolisovo zrýchlenie",
    "k_C.meets": "Coriolisova sila nemá moment k osi {i}: jej nositeľka je s osou rôznobežná alebo rovnobežná",
    "k_C.meets.slide": "Coriolisova sila je kolmá na posuv {i}",
    "k_C.cancel": "momenty Coriolisových síl k osi {i} dajú v súčte nulu",
    "k_C.cancel.slide": "zložky Coriolisových síl v smere posuvu {i} dajú v súčte nulu",
    "weights": "{name} je moment, ktorý drží spojenie {joint} v pokoji proti tiažam.",
    "weights.slide": "{name} je sila, ktorá drží spojenie {joint} v pokoji proti tiažam.",
    "weights.reason": "Momenty tiaží za osou {drive}, sčítané bez energie, s opačným znamienkom.",
    "weights.slide.reason": "Zložky tiaží za posuvom {drive} v jeho smere, sčítané bez energie, s opačným znamienkom.",
    "weights.caption": "Tiaže, každá vo svojom ťažisku.",
    # numbers
    "state": "Zvolíme jeden stav a hodnoty parametrov.",
    "state.reason": "Parametre, ktoré v zadaní hodnotu nemajú, ju dostanú tu, každý inú.",
    "state.reason.closed": "Slučky tieto rýchlosti a zrýchlenia dovoľujú; parametre, ktoré v zadaní hodnotu nemajú, "
    "ju dostanú tu.",
    "values": "Koeficienty v tejto polohe:",
    "torque": "Spolu {total} {value}.",
    "torque.passive": "Členy rovnice súradnice {q} dajú v súčte {total} {value}. Súradnicu {q} nič nepoháňa: toto "
    "by tam zvolený pohyb potreboval; pre pohyb, ktorý mechanizmus koná sám, je to nula.",
    "shares": "Z čoho sa skladá {total}: každý stĺpec je jeden súčin, jeho dĺžka je podiel na súčte veľkostí.",
    "equilibria": "Kde mechanizmus zotrvá v pokoji bez pohonov.",
    "equilibria.reason": "V pokoji pôsobí len tiaž, pružiny a stále sily; rušia sa tam, kde je ich potenciálna energia "
    "stacionárna. Rovnováha je stabilná v jej minime. Čo je presné, platí pre všetky hodnoty parametrov.",
    "equilibria.newton": "Okrem presných polôh hľadala ďalšie Newtonova metóda pre hodnoty uvedené vyššie (počet "
    "začiatočných odhadov: {starts}); niektoré mohla vynechať.",
    "equilibria.turn": "Okrem presných polôh sa hľadali zmeny znamienka síl v celej otáčke, s krokom pol stupňa, pre "
    "hodnoty uvedené vyššie.",
    "equilibria.turns": "Okrem presných polôh sa hľadali zmeny znamienka síl od {q} = {least} po {most}, s krokom pol "
    "stupňa, pre hodnoty uvedené vyššie; mimo týchto hraníc môžu existovať ďalšie.",
    "equilibria.singular": "Zovšeobecnené sily sa rušia aj v polohách {places}, rovnovážne však nie sú. Súradnice sú "
    "tam singulárne: nedá sa nimi opísať každý pohyb, ktorý členy môžu konať, a na tom, ktorý sa opísať nedá, sily "
    "konajú prácu, ako ukazuje virtuálna práca pri pohybe všetkých členov.",
    "equilibria.driven": "Niektorý pohyb je tu predpísaný alebo niektorá sila závisí od času: mechanizmus je budený, a "
    "rovnovážne polohy sa preto neuvádzajú.",
    "equilibria.all": "Každá poloha je rovnovážna: žiadna sila nezávisí od polohy.",
    "equilibria.never": "Rovnovážna poloha nie je: čo pôsobí v pokoji, nezávisí od polohy a nie je nulové.",
    "equilibria.none": "Žiadna sa nenašla.",
    "equilibria.idle": "Na týchto súradniciach nezáleží: {names}.",
    "equilibria.kind": "druh",
    "equilibria.how": "nájdená",
    "equilibria.stable": "stabilná",
    "equilibria.unstable": "nestabilná",
    "equilibria.undecided": "druhé derivácie nerozhodnú",
    "equilibria.exact": "presne",
    "equilibria.numeric": "numericky",
    "power": "Kontrola energiou: výkon pohonov a ostatných síl je deriváciou mechanickej energie podľa času.",
    "power.reason": "Každú rovnicu vynásobíme jej rýchlosťou a sčítame: súčet je deriváciou súčtu kinetickej a "
    "potenciálnej energie.",
    "power.numbers": "Vo zvolenom stave {left} {value} W a pravá strana je ({parts}) W.",
    # textbook
    "textbook.signs.title": "Znamienka",
    "textbook.signs": "Tu má každý koeficient svoje znamienko v sebe. Kniha píše mínus Coriolisových a odstredivých "
    "výrazov pred ne, a preto tieto koeficienty uvádza s opačným znamienkom.",
    "erratum": "Text vzťahu ({number}) je chybný",
    "erratum.several": "Text vzťahov ({number}) je chybný",
    "erratum.reads": "V prepise stojí (v tu použitých znamienkach): {left} = {form}.",
    "erratum.right": "Správne je:",
    "erratum.check": "Kontrola v stave z poslednej časti: text dáva {wrong}; z energií bez textu vychádza "
    "{left} {right}.",
    "erratum.5.33": "Znamienko: y rastie nahor a potenciálna energia s výškou rastie. Vzťah (5.34) je správny.",
    "erratum.5.37": "Tretí výraz obsahuje rýchlosť druhého spojenia namiesto prvého. Vzťah (5.38) je správny.",
    "erratum.5.40z": "Koeficient pri druhom zrýchlení je označený ako koeficient druhej rovnice a obsahuje prvú "
    "hmotnosť namiesto druhej. Vzťah (5.51) je správny.",
    "erratum.5.40D": "Koeficient pri druhej mocnine druhej rýchlosti má kosínus namiesto sínusu. Vzťah (5.38) je "
    "správny.",
    "erratum.5.41": "Hybnosť obsahuje rýchlosti, nie zrýchlenia ani ich druhé mocniny.",
    "erratum.5.42": "Deriváciou rýchlosti je zrýchlenie, nie druhá mocnina rýchlosti.",
    "erratum.5.43": "Chýba druhá mocnina prvej rýchlosti a hmotnosť nemá index (v kontrole sa číta ako druhá).",
    "erratum.5.44C": "Druhá rovnica nemá Coriolisov výraz: to, čo dá derivácia hybnosti, a to, čo dá derivácia "
    "kinetickej energie podľa súradnice, sa ruší.",
    "erratum.5.44D": "Znamienko odstredivého výrazu: pri otáčaní okolo prvej osi je druhý člen odstreďovaný a jeho "
    "pohon ho musí držať.",
    "erratum.axes": "Osi spojení sú tam označené ako uhlové rýchlosti; sú to osi.",
    # D'Alembert's road
    "title.dalembert": "Sily v mechanizme {scene} D'Alembertovou metódou krok za krokom",
    "section.count": "Rovnice a neznáme",
    "section.bodies": "Člen po člene",
    "section.reactions": "Reakcie a hnacie účinky",
    "section.roads": "Obe cesty sa zhodujú",
    "scene.closed": "{scene} je mechanizmus so slučkami alebo inými väzbami. Počet pohyblivých členov: {bodies}; "
    "počet súradníc spojení, kým ich väzby nezviažu: {freedoms}.",
    "scene.closed.reason": "Niektoré spojenia uzatvárajú slučky: nenesú člen a nemajú vlastnú súradnicu.",
    "table.class": "trieda t",
    "table.dalembert": "podľa D'Alemberta",
    "table.lagrange": "podľa Lagrangea",
    "unknowns": "Každé spojenie prenáša to, čo nenecháva voľné; poháňané spojenie pridáva hnací účinok.",
    "unknowns.reason": "Spojenie triedy t má t neznámych súradníc; píšu sa v osiach jeho vlastného súradnicového "
    "systému. Rám je člen 0; učebnica ho čísluje ako člen 1 a každý ďalší člen o jednotku vyššie.",
    "unknown.drive": "hnací účinok v spojení {joint}",
    "unknown.idle": "hnací účinok, ktorý by potrebovala voľnosť v spojení {joint}; nič ju nepoháňa, vyjde nulový",
    "unknown.passive": "čo by potreboval pohyb v spojení {joint}: nič ho nepoháňa",
    "unknown.force": "sila v spojení {joint} v smere jeho osi {axis}",
    "unknown.moment": "moment v spojení {joint} okolo jeho osi {axis}",
    "unknown.coupling": "čo drží spojenie {joint} spriahnuté so spojením {leader}",
    "unknown.other": "zložka toho, čo prenáša spojenie {joint}",
    "loops": "Slučky a iné väzby viažu súradnice: tieto rovnice platia v každom okamihu.",
    "loops.positions": "Polohy, v osiach rámu alebo spojenia, ktoré slučku uzatvára:",
    "loops.rates": "Rýchlosti: časové derivácie polôh, lineárne v rýchlostiach.",
    "loops.reason": "Každé z týchto spojení drží bod jedného člena v bode druhého: {joints}. Po oboch vetvách slučky "
    "má ten bod rovnaké súradnice. Po ďalšom derivovaní rovnice viažu zrýchlenia.",
    "count": "Počet rovníc je {equations}.",
    "count.sum": "(5.18): {each} · {bodies} = {equations} rovníc, počet pohyblivých členov je {bodies}. (5.19), "
    "trieda krát počet spojení v súčte: v spojeniach je {m} = {sum} = {reactions} neznámych reakcií. Neznáme hnacie "
    "účinky: n = {drives}.",
    "count.coupled": "Spojenie, ktoré nasleduje iné ({joints}), prenáša o jednu zložku viac, a to zo spriahnutia; jeho "
    "trieda ju počíta.",
    "count.idle": "Voľnosti, ktoré nič nepoháňa: {number} (zapísané v spojení {joints}), napríklad voľné otáčanie "
    "tyče medzi dvoma guľami. n ich zahŕňa, lebo je to pohyblivosť; pre pohyb, ktorý tam mechanizmus koná sám, vyjdú "
    "ich hnacie účinky nulové.",
    "count.passive": "Spojenia bez pohonu: {number} ({joints}). Vyjde tam to, čo by zvolený pohyb potreboval; pre "
    "pohyb, ktorý mechanizmus koná sám, je to nula.",
    "count.correct": "(5.20): {equations} = {drives} + {reactions}, rovníc je toľko ako neznámych: sústava je "
    "korektná.",
    "count.over": "(5.20) neplatí: {equations} sa nerovná {drives} + {reactions}. Mechanizmus je preurčený, alebo je "
    "pohonov viac či menej než voľností.",
    "count.plane": "Mechanizmus sa pohybuje v rovine: sily kolmé na ňu a momenty okolo osí v nej sa vynechávajú a "
    "trieda počíta to, čo leží v rovine (2 pre rotačné alebo posuvné spojenie, ktoré je v priestore triedy 5).",
    "free": "Člen {number}, {body}, uvoľníme.",
    "free.caption": "Uvoľnený člen {body}: všetky sily a dvojice, ktoré naň pôsobia.",
    "free.reason": "Jeho súradnicový systém {number} má osi člena a začiatok vo vzťažnom spojení {joint}.",
    "free.centre": " Dvojice s indexom T sú k ťažisku T, v ktorom sú nakreslené ich sily; momenty vo vzorcoch sú k "
    "začiatku O súradnicového systému {number}.",
    "frame": "Súradnicový systém {number} člena {body} vzhľadom na rám.",
    "frame.reason": "P obsahuje smerové kosínusy jeho osí, r s vlnkou polohu jeho začiatku ako antisymetrickú maticu. "
    "Nimi sa každá sila a moment člena prenesú do rámu podľa (5.5): sila sa násobí maticou P, moment tiež a pripočíta "
    "sa k nemu r s vlnkou krát sila.",
    "moved": "Ako sa člen {body} pohybuje a čo to vyžaduje.",
    "moved.reason": "Zotrvačná sila je mínus hmotnosť krát zrýchlenie: ťažiska v (5.11), začiatku súradnicového "
    "systému v (5.16). Transponovaná P otočí (5.11) do osí člena, (5.12) a (5.13). Moment (5.14) je mínus zotrvačnosť "
    "krát uhlové zrýchlenie, mínus gyroskopický výraz, plus rameno ťažiska vektorovo krát (5.16).",
    "erratum.5.1b": "Druhá zložka momentu je označená {reads}; má byť {right}: prvý index je priestor, druhý člen, "
    "tretí os. Kontrola: všetky ostatné zložky v (5.1) majú na začiatku jj.",
    "erratum.5.3": "Jeden symbol označuje antisymetrickú maticu (5.2) aj prenos bivektora (5.3); sú to r s vlnkou, "
    "tri riadky a stĺpce, a R s pruhom, šesť. Kontrola: v (5.5) prenos násobí bivektor, ktorý má šesť riadkov.",
    "erratum.5.16": "V texte je poloha namiesto zrýchlenia. Vzťah (5.11) je správny.",
    "erratum.5.16.check": "Kontrola v číslach, v stave uvedenom v časti o reakciách: po dosadení do (5.14) text dáva "
    "{left} {wrong}; pohyb vyžaduje {left} {right}.",
    "bivectors": "Čo pôsobí na člen {body}: sila nad momentom k začiatku jeho súradnicového systému.",
    "bivectors.reason": "Akčné účinky A: tiaž, zaťaženia, pružiny, trenie. Zotrvačné účinky D: mínus hmotnosť krát "
    "zrýchlenie ťažiska a moment (5.14). Reakcie R vo vzťažnom spojení a s hviezdičkou v ostatných spojeniach, opačné "
    "k tomu, čo pôsobí na suseda.",
    "balance": "Člen {body} je v dynamickej rovnováhe.",
    "balance.reason": "Ak zotrvačné sily počítame medzi sily, súčet všetkých bivektorov člena je nulový.",
    "solved": "Rovnice riešime pre všetky reakcie a hnacie účinky.",
    "solved.reason": "Od konca k rámu: rovnice posledného člena obsahujú len to, čo prenáša jeho vlastné spojenie.",
    "reactions": "V číslach:",
    "reactions.open": "V stave uvedenom vyššie:",
    "reactions.closed": "V slučkách sú všetky rovnice zviazané a žiaden člen sa nedá riešiť pred ostatnými; v stave "
    "uvedenom vyššie, ktorého rýchlosti a zrýchlenia slučky dovoľujú:",
    "reactions.least": "Hodnoty nie sú jednoznačné; toto sú najmenšie.",
    "reactions.reason": "Tá istá sústava, riešená numericky.",
    "roads": "Lagrangeova cesta dáva tie isté hnacie účinky.",
    "roads.open": "Riešenie uvedené vyššie a Lagrangeove rovnice sú tie isté funkcie a po dosadení riešenia do (5.18) "
    "nezostane nič.",
    "roads.drives": "Presné riešenie (5.18) pre hnacie účinky a Lagrangeove rovnice s multiplikátormi sú tie isté "
    "funkcie.",
    "roads.joints": "Čo reakcie a hnacie účinky konajú pozdĺž pohybu každého spojenia, je to, čo žiada virtuálna "
    "práca.",
    "roads.power": "Výkon všetkých reakcií spolu je výkonom pohonov a toho, čo pôsobí v spojeniach.",
    "roads.momentum": "Účinok rámu spolu s tiažami a zaťaženiami je deriváciou hybnosti podľa času.",
    "roads.proved": "Porovnané hnacie účinky: {names}. Dokázané v náhodných bodoch (počet {points}) nad náhodnými "
    "konečnými poľami (počet {primes}); pravdepodobnosť omylu je menšia než {chance}.",
    "roads.numbers": "V číslach, v stave uvedenom vyššie:",
    "roads.reason": "Lagrangeove rovnice reakcie nepoznajú, lebo reakcie nekonajú prácu; D'Alembertova metóda nájde "
    "všetky. Spoločné majú len zadanie.",
    # exercises and the page
    "page.contents": "Obsah",
    "section.live": "Vyskúšajte",
    "section.solutions": "Riešenia",
    "exercise.how": "Niektoré výsledky tu chýbajú: doplňte ich do polí, obyčajným textom, napríklad 2*m1*h1^2*cos(q1 "
    "+ q2)*q1'^2, alebo v LaTeXu. Platí každý rovnaký tvar. Stránka porovnáva hodnoty a nepotrebuje "
    "sieť.",
    "exercise.script": "Polia kontrolujú odpovede pomocou JavaScriptu, ktorý je tu vypnutý; riešenia sú na konci.",
    "exercise.example": "napríklad 2*m1*h1^2*cos(q1 + q2)*q1'^2",
    "exercise.check": "Skontrolovať",
    "exercise.hint": "Pomôcka",
    "exercise.solution": "Riešenie",
    "exercise.ask": "Čomu sa rovná {left}?",
    "exercise.later": "Vypísaný výraz vyplýva z toho, na čo sa tu pýtame; je medzi riešeniami.",
    "exercise.solved": "{left} nájdeme takto.",
    "exercise.hint.square": "Umocnite obe rýchlosti, sčítajte ich a použite sin² + cos² = 1 a súčtový vzorec.",
    "exercise.hint.potential": "Hmotnosť krát tiažové zrýchlenie krát výška; výška je medzi polohami.",
    "exercise.hint.momentum": "Derivujte len podľa tejto rýchlosti; všetko ostatné je konštanta.",
    "exercise.hint.slope": "Derivujte len podľa tejto súradnice; rýchlosti sú konštanty.",
    "exercise.hint.equation": "Časová derivácia hybnosti bez derivácie Lagrangiánu podľa súradnice.",
    "exercise.hint.coefficients": "Prečítajte ho z pohybových rovníc: násobí zrýchlenia alebo rýchlosti svojich "
    "indexov, aj so "
    "znamienkom.",
    "exercise.hint.bivectors": "Dosaďte pohyb člena do (5.14); jeho zotrvačnosť, uhlová rýchlosť a (5.16) sú uvedené "
    "vyššie.",
    "exercise.hint.solved": "Začnite posledným členom: jeho momentová rovnica k osi obsahuje len hnací účinok.",
    "answer.right": "Správne.",
    "answer.shifted": "Správne; nula potenciálnej energie leží inde, čo pridáva konštantu a je voľné.",
    "answer.turned": "Ešte nie: celý výraz má opačné znamienko.",
    "answer.factor": "Ešte nie: váš výraz je {factor}-násobok výsledku.",
    "answer.rounded": "Ešte nie: výraz je správny len na niekoľko číslic; píšte presné čísla.",
    "answer.numbers": "Ešte nie: výraz je správny len pre čísla tejto scény; namiesto nich píšte symboly.",
    "answer.wrong": "Ešte nie: výraz má inú hodnotu.",
    "answer.undefined": "Výraz nemá hodnotu: delí nulou alebo odmocňuje záporné číslo.",
    "fault.empty": "Nič tu nie je napísané.",
    "fault.quantity": "{text} je len názov výsledku; vypíšte ho v symboloch mechanizmu.",
    "fault.time": "Derivácie sa čítajú len pri súradniciach, napríklad q' alebo d/dt q; ostatné najprv vypočítajte.",
    "fault.name": "{text} tu nie je symbolom.",
    "fault.ambiguous": "{text} sa dá čítať viacerými spôsobmi; medzi činitele dajte medzery.",
    "fault.character": "{text} nepatrí do vzorca.",
    "fault.bracket": "Táto zátvorka nie je uzavretá.",
    "fault.end": "Na konci niečo chýba.",
    "fault.here": "{text} sem nepatrí.",
    "fault.power": "Exponent je celé číslo do 32 alebo 1/2; viac číslic v zložených zátvorkách.",
    "fault.argument": "sin a cos potrebujú uhol: sin(q).",
    "fault.division": "Delí sa jedným činiteľom alebo všetkými? Napíšte a/(b c) alebo (a/b) c.",
    "fault.dots": "{text} nemá bodky; majú ich len súradnice.",
    "fault.deep": "Je to príliš dlhé alebo príliš vnorené.",
}
