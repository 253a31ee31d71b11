/* Of several words, a section is found by the share that its index entries hold, or its title: entries whole, titles in part. */
{
  const exact = Search._performSearch;
  const stemmer = new Stemmer();
  const stems = (text) => {
    const words = splitQuery(text.toLowerCase()).filter((word) => !stopwords.has(word));
    return words.map((word) => stemmer.stemWord(word));
  };

  Search._performSearch = (query, terms, ...others) => {
    const results = exact(query, terms, ...others);
    if (terms.size < 2) return results;
    const { docnames, filenames, titles, alltitles, indexentries } = Search._index;
    const sections = new Map();
    const add = (file, id, words, weight) => {
      const key = `${file}#${id}`;
      if (!sections.has(key)) sections.set(key, { file, id, words: new Map() });
      const held = sections.get(key).words;
      words.forEach((word) => held.set(word, Math.max(held.get(word) ?? 0, weight)));
    };
    for (const [entry, places] of Object.entries(indexentries)) {
      const words = stems(entry);
      if (!words.length || !words.every((word) => terms.has(word))) continue;
      places.forEach(([file, id, main]) => main && add(file, id, words, 1));
    }
    for (const [title, places] of Object.entries(alltitles)) {
      const words = stems(title);
      const shared = words.filter((word) => terms.has(word));
      if (!shared.length) continue;
      places.forEach(([file, id]) => add(file, id ?? "", shared, 0.5 + (0.4 * shared.length) / words.length));
    }
    for (const { file, id, words } of sections.values()) {
      const share = [...words.values()].reduce((sum, weight) => sum + weight, 0) / terms.size;
      if (share < 0.3) continue;
      const hit = [docnames[file], titles[file], id && `#${id}`, null, 70 * share, filenames[file], SearchResultKind.index];
      hit[4] = Scorer.score(hit);
      results.push(hit);
    }
    return results.sort((a, b) => a[4] - b[4]);
  };
}
