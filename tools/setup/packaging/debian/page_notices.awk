# SPDX-License-Identifier: Apache-2.0
# The paragraph of a copyright file for what the page of drape_report contains, from the notices in
# the page itself: <h3>name (licence)</h3><pre>text</pre>.
function Say(line) {
  gsub(/&lt;/, "<", line); gsub(/&gt;/, ">", line); gsub(/&quot;/, "\"", line); gsub(/&amp;/, "\\&", line)
  sub(/[ \t]+$/, "", line)
  print (line == "" ? " ." : " " line)
}
BEGIN {
  print "\nFiles: usr/share/drapefit/report/page/template.html"
  print "Copyright: 2026 The drapefit maintainers, and those that the notices below name"
  print "License: GPL-3+ and notices-of-the-page"
  print "\nLicense: notices-of-the-page"
  print " The page that drape_report writes contains libraries under these terms."
}
/^<h3>.*<\/h3><pre>/ {
  name = $0; sub(/^<h3>/, "", name); sub(/<\/h3>.*/, "", name)
  sub(/^<h3>.*<\/h3><pre>/, "")
  print " ."
  Say("--- " name)
  inside = 1
}
inside {
  ends = sub(/<\/pre>.*/, "")
  Say($0)
  if (ends) inside = 0
}
