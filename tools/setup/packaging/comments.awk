# SPDX-License-Identifier: Apache-2.0
# A header as Doxygen reads it: comments before a declaration become ///, those behind a member
# ///<, as plain text: what Doxygen would take for a command is escaped. A comment that a blank line
# separates from what follows stays one, and so do comments that begin with ///.
function Escape(text) {
  gsub(/[\\@#%]/, "\\\\&", text)
  gsub(/&/, "\\&amp;", text); gsub(/</, "\\&lt;", text); gsub(/>/, "\\&gt;", text)
  while (match(text, /`[^`]+`/))
    text = substr(text, 1, RSTART - 1) "<code>" substr(text, RSTART + 1, RLENGTH - 2) "</code>" \
           substr(text, RSTART + RLENGTH)
  return text
}
# The code before a comment that says what it declares.
function IsMember(code) {
  return code ~ /[;,]$/ || code ~ /^ *[^ }].*}$/ || code ~ /^ *[A-Za-z0-9_]+( = [^{]*)?$/
}
function Flush(mark,   i) {
  for (i = 1; i <= held; ++i) {
    if (mark != "") sub(/\/\/ ?/, "", block[i])
    match(block[i], /^ */)
    print mark == "" ? block[i] : substr(block[i], 1, RLENGTH) mark " " Escape(substr(block[i], RLENGTH + 1))
  }
  held = 0
}
{
  if (match($0, /^ *\/\/($|[^\/])/) && match($0, /^ *\/\//)) {
    if (behind && RLENGTH - 1 == behind) {  # goes on below the comment behind a member
      print substr($0, 1, RLENGTH - 2) "///< " Escape(substr($0, RLENGTH + 2))
      next
    }
    behind = 0
    block[++held] = $0
    next
  }
  behind = 0
  free = /^ *$/ || /^ *(#|}|namespace|using namespace|extern)/ || /SPDX/
  Flush(free ? "" : "///")
  if (match($0, / +\/\/ /) && IsMember(substr($0, 1, RSTART - 1))) {
    behind = RSTART + RLENGTH - 3  # the column of the slashes
    print substr($0, 1, behind - 1) "///< " Escape(substr($0, RSTART + RLENGTH))
  } else {
    print
  }
}
END { Flush("") }
