// What the page says, in its languages.

export const WORDS = {
  en: {
    playground: "playground", examples: "Examples", open: "Open", save: "Save", share: "Share", language: "Language",
    reload: "Load it", loading: "loading …", hint: "Ctrl+Space completes, Ctrl+S saves", picture: "Picture", pull: "Pull it",
    back: "As it is written", equations: "Equations of motion", coefficients: "Coefficients", motion: "Motion",
    motion_is: "sliders, energy, phase portrait", lesson: "Lesson", lesson_is: "the derivation, step by step",
    exercises: "with exercises: results to be found, and checked",
    load: "Load NumPy and SciPy",
    small: host => "Python here has a small NumPy and no SciPy; lessons leave out what takes them. " +
      `The real ones: about 20 MB from ${host}; nothing of your scene is sent.`,
    loading: (name, done, all) => `${name}: ${done} ${all ? `of ${all} ` : ""}MB …`,
    starting: "Python begins again, with NumPy and SciPy …",
    large: by => `Python here has NumPy ${by.numpy} and SciPy ${by.scipy}.`,
    unreached: name => `${name} cannot be loaded: there is no network, or no such file. Nothing has changed.`,
    another: name => `${name} is not the file that Pyodide published: its SHA-256 is another. It was thrown away, and nothing has changed.`,
    unstarted: why => `Python does not begin with them (${why}). It goes on without.`,
    by_before: "Made beforehand, with NumPy and SciPy.",
    by_small: "Made in this page, with its small NumPy and without SciPy.",
    by_large: by => `Made in this page, with NumPy ${by.numpy} and SciPy ${by.scipy}.`,
    needs: "This takes NumPy or SciPy, which the page can load: below the scene.",
    code: "Code", target: "Language of the code", copy: "Copy", download: "Download", editor: "The scene, in TOML",
    faulty: (n, before) => `${one(n, "mistake", "mistakes")}; ` +
      (before ? `what is shown is the scene before ${n === 1 ? "it" : "them"}` : `without ${n === 1 ? "it" : "them"} the scene is shown`),
    counts: s => `${one(s.bodies, "body", "bodies")}, ${one(s.joints + s.loops, "joint", "joints")}, ` +
      one(s.freedoms, "velocity", "velocities"),
    line: n => `line ${n}`, working: "working …", python: "loading Python, 13 MB the first time …", ended: "symdyn has ended; start it again to go on",
    saved: name => `${name} is written`, copied: "The link is copied; the scene is in it", linked: "The link stands in the address; the scene is in it",
    local: "It opens wherever this page runs",
    changed: name => `${name} was changed by another program`, unreadable: why => `The link cannot be read: ${why}`,
    long: "it is longer than 20,000 letters", much: "it holds more than 200 kB", broken: "it is broken, or was cut off; ask for it again",
    unlinked: "The scene is too long for a link; save it, and send the file",
    huge: "The file is too large for a page", picture_of: name => `picture of ${name}`, taken: "Copied",
  },
  sk: {
    playground: "ihrisko", examples: "Príklady", open: "Otvoriť", save: "Uložiť", share: "Zdieľať", language: "Jazyk",
    reload: "Načítať", loading: "načítava sa …", hint: "Ctrl+medzera dopĺňa, Ctrl+S ukladá", picture: "Obrázok",
    pull: "Pohnúť", back: "Ako je napísané", equations: "Pohybové rovnice", coefficients: "Koeficienty", motion: "Pohyb",
    motion_is: "posuvníky, energia, fázový portrét", lesson: "Lekcia", lesson_is: "odvodenie, krok za krokom",
    exercises: "s úlohami: výsledky treba nájsť a skontrolujú sa",
    load: "Načítať NumPy a SciPy",
    small: host => "Python tu má malý NumPy a nemá SciPy; lekcie vynechávajú, čo ich potrebuje. " +
      `Skutočné: asi 20 MB z ${host}; z vašej scény sa nič neposiela.`,
    loading: (name, done, all) => `${name}: ${done} ${all ? `z ${all} ` : ""}MB …`,
    starting: "Python začína znova, s NumPy a SciPy …",
    large: by => `Python tu má NumPy ${by.numpy} a SciPy ${by.scipy}.`,
    unreached: name => `${name} sa nedá načítať: niet siete alebo takého súboru. Nič sa nezmenilo.`,
    another: name => `${name} nie je súbor, ktorý zverejnilo Pyodide: má iný SHA-256. Bol zahodený a nič sa nezmenilo.`,
    unstarted: why => `Python s nimi nezačne (${why}). Pokračuje bez nich.`,
    by_before: "Pripravené vopred, s NumPy a SciPy.",
    by_small: "Vzniklo na tejto stránke, s jej malým NumPy a bez SciPy.",
    by_large: by => `Vzniklo na tejto stránke, s NumPy ${by.numpy} a SciPy ${by.scipy}.`,
    needs: "Toto potrebuje NumPy alebo SciPy, ktoré stránka vie načítať: pod scénou.",
    code: "Kód", target: "Jazyk kódu", copy: "Kopírovať", download: "Stiahnuť", editor: "Scéna v TOML",
    faulty: (n, before) => `${few(n, "chyba", "chyby", "chýb")}; ${before ? "zobrazená je scéna predtým" : "scéna sa zobrazí po oprave"}`,
    counts: s => `${few(s.bodies, "teleso", "telesá", "telies")}, ${few(s.joints + s.loops, "väzba", "väzby", "väzieb")}, ` +
      few(s.freedoms, "rýchlosť", "rýchlosti", "rýchlostí"),
    line: n => `riadok ${n}`, working: "počíta sa …", python: "načítava sa Python, prvý raz 13 MB …", ended: "symdyn skončil; spustite ho znova",
    saved: name => `${name} je zapísaný`, copied: "Odkaz je skopírovaný; scéna je v ňom", linked: "Odkaz je v adrese; scéna je v ňom",
    local: "Otvorí sa všade, kde beží táto stránka",
    changed: name => `${name} zmenil iný program`, unreadable: why => `Odkaz sa nedá prečítať: ${why}`,
    long: "je dlhší než 20 000 znakov", much: "obsahuje viac než 200 kB", broken: "je poškodený alebo skrátený; vypýtajte si ho znova",
    unlinked: "Scéna je pre odkaz pridlhá; uložte ju a pošlite súbor",
    huge: "Súbor je pre stránku priveľký", picture_of: name => `obrázok: ${name}`, taken: "Skopírované",
  },
};

function one(n, single, several) {
  return `${n} ${n === 1 ? single : several}`;
}

function few(n, single, some, many) {
  return `${n} ${n === 1 ? single : n > 1 && n < 5 ? some : many}`;
}
