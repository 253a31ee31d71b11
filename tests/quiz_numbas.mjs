// Marks answers by Numbas' own runtime. NUMBAS is a copy of its source where `npm install` was run in tests/.
// Input: {exam: text, variant, answers: [[number of the part, answer], ...]}; output: [[credit, words], ...].
import {createRequire} from 'module';
import {readFileSync} from 'fs';

const place = `${process.env.NUMBAS}/tests/`;
const {JSDOM} = createRequire(place)('jsdom');
globalThis.window = new JSDOM('').window;
globalThis.document = window.document;
for (const name of ['numbas-runtime.js', 'locales.js', 'marking_scripts.js', 'diagnostic_scripts.js']) await import(place + name);

const {exam, variant, answers} = JSON.parse(readFileSync(0, 'utf8'));
const parts = ['numberentry', 'jme', 'multipleresponse', 'patternmatch', 'gapfill'].map(name => `parts/${name}`);
Numbas.queueScript('base', [], () => {});
Numbas.queueScript('answers', ['json', 'jme', 'localisation', 'question', 'exam', 'marking', 'marking_scripts', ...parts], async () => {
  Numbas.locale.set_preferred_locale('en-GB');
  Numbas.locale.init();
  const [{questions: [json]}] = JSON.parse(exam.slice(exam.indexOf('\n') + 1)).question_groups;
  json.variables.quiz_variant.definition = String(variant);
  const question = Numbas.createQuestionFromJSON(json, 0);
  question.generateVariables();
  await question.signals.on('ready');
  const told = answers.map(([k, answer]) => {
    const part = question.parts[k];
    part.storeAnswer(answer);
    part.setStudentAnswer();
    const {credit, states, warnings} = part.mark(part.getScope()).finalised_result;
    return [credit, [...(states || []).map(one => one.message).filter(Boolean), ...(warnings || [])].join(' ')];
  });
  process.stdout.write(JSON.stringify(told), () => process.exit(0));
});
