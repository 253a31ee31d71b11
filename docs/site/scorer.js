/* How the site's search weighs what it finds: pages for users before those about the inside, pages before their members. */
var Scorer = {
  score: ([docname, title, anchor, descr, score, filename, kind]) => {
    if (kind !== "index" && /^(decisions|architecture|theory|performance|performance-of-runs|accuracy|accuracy-of-code|operation-counts|formulations)$/.test(docname)) return score * 0.3;
    if (/^walkthroughs\//.test(docname)) return score * 0.3;
    if (kind === "object" && anchor.split(".").length > 3) return score * 0.5;
    if (/^(start|howto|simulate|linearize|control|equations|scenes)$/.test(docname)) return score * 1.2;
    return score;
  },
  objNameMatch: 16,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
