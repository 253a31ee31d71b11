"""Exercises as a question folder of PrairieLearn, whose server.py asks symdyn's own checker."""

from __future__ import annotations

import json
from uuid import NAMESPACE_URL, uuid5

from symdyn.emit import render
from symdyn.emit.code import page_stem
from symdyn.scene import write_text
from symdyn.teach.document import Choice
from symdyn.teach.render.quiz_text import Quiz


def prairielearn(quiz: Quiz) -> dict[str, str]:
    """Return the files of the folder by name: info.json, question.html, server.py, scene.toml."""
    folder, scene = f"{page_stem(quiz.scene.name)}-prairielearn", write_text(quiz.scene, "toml").text
    seeds = [one.seed for one in quiz.variants]
    info = {
        "uuid": str(uuid5(NAMESPACE_URL, json.dumps([scene, seeds, quiz.keys, dict(quiz.settings)]))),
        "title": quiz.variants[0].document.title,
        "topic": "Mechanics",
        "tags": ["symdyn"],
        "type": "v3",
        "partialCredit": True,
        "singleVariant": len(seeds) == 1,
    }
    server = {"title": quiz.scene.name, "seeds": seeds, "keys": list(quiz.keys), "settings": dict(quiz.settings)}
    asked = [isinstance(quiz.parts(key)[0].asked, Choice) for key in quiz.keys]
    return {
        f"{folder}/info.json": json.dumps(info, ensure_ascii=False, indent=2) + "\n",
        f"{folder}/question.html": render("quiz/question.html.jinja", {"parts": asked}),
        f"{folder}/server.py": render("quiz/server.py.jinja", server),
        f"{folder}/scene.toml": scene,
    }
