#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A commit has a subject of at most 60 characters that begins with a verb in the imperative, an empty
# line, and a body with the reason.
# usage: commits.sh <source folder> [<base>..<head>]    the last commit if no range is given
set -euo pipefail
export LC_ALL=C
cd "$1"
range=${2:-}

if ! git rev-parse 2>/dev/null || { [ -n "$range" ] && ! git rev-parse "$range" >/dev/null 2>&1; }; then
  printf 'tests/repository/rules/commits.sh: Skipped\nno git checkout with %s here\n' "${range:-commits}"
  exit 77
fi
# shellcheck disable=SC2086
git log --no-merges --format='%x01%h%x02%s%x02%B' ${range:--1} | awk -v RS='\001' -v FS='\002' '
  function Report(what) { print $1 ": " what ": " $2; bad = 1 }
  BEGIN {
    # Nouns, pronouns and other first words that are no verbs, and endings that no imperative has.
    n = split("A An And All Also Another As At Back Best Better Bug Bugs By Chart Charts CI Code Comment Comments " \
              "Defect Defects Doc Docs Documentation Each Eleven English Error Errors Every Few Figure Figures " \
              "First Five Fits For Four Four From Glossary GPU CPU CUDA Header Headers How In Its It Last Less " \
              "Library Many Misc Model Models More Most Name Names New Nine No Note Notes Now Of On One Only Other " \
              "Our Picture Pictures Prose README Result Results Room Rooms Same Second Seven Six Small Some " \
              "Source Sources Still Stuff Table Tables Ten Text Texts That The These They Third This Three Time " \
              "Times To Tool Tools Two Typo Typos Various We What When Where Which Why With Without WIP Word Words", word, " ")
    for (i = 1; i <= n; ++i) no_verb[word[i]] = 1
    # Verbs that end as past tenses, participles or third persons do.
    n = split("Bring Pass Process Address Discuss Focus Bias Miss Compress Express Access Embed Feed Need Seed " \
              "Shed Speed Exceed Proceed Bless String Ring Sling Toss Cross Suppress Guess Assess Press Stress " \
              "Ping Swing Wing Mention Partition Position Condition Question Caution Harness Witness", word, " ")
    for (i = 1; i <= n; ++i) verb[word[i]] = 1
  }
  NR == 1 { next }
  {
    subject = $2
    shown = subject
    gsub(/[\200-\277]/, "", shown)
    if (length(shown) > 60) Report(length(shown) " characters, at most 60")
    first = subject
    sub(/[^A-Za-z-].*/, "", first)
    if (first !~ /^[A-Z]/) Report("begins with no verb in upper case")
    else if (!(first in verb) && (first in no_verb || first ~ /(ed|ing|tion|ness|ity|[^s]s)$/ || first ~ /^[A-Z]+$/))
      Report("\"" first "\" is no verb in the imperative")
    else if (subject !~ / /) Report("names no object")
    if (subject ~ /\.$/) Report("ends with a full stop")
    if (subject ~ /;/) Report("has several topics")
    body = $3
    if (!sub(/^[^\n]*\n/, "", body)) body = ""
    if (body != "" && body !~ /^\n/ && body ~ /[^ \n]/) Report("no empty line after the subject")
    gsub(/(^|\n)[A-Z][A-Za-z-]+-[Bb]y: [^\n]*/, "", body)
    if (body !~ /[^ \n]/) Report("has no body with the reason")
  }
  END { exit bad }'
