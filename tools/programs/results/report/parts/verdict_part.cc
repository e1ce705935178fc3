// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/report/parts/verdict_part.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "tools/programs/results/report/parts/html_text.h"

namespace drape {
namespace {

constexpr double kKes = 98.07;       // µN·m of 1 gf·cm²/cm
constexpr double kKesShear = 56.19;  // N/m of 1 gf/(cm·degree)

struct Number {
  std::string name, value;
};

std::string NumberList(const std::vector<Number>& numbers) {
  if (numbers.empty()) return "";
  std::string html = "<dl class=\"numbers\">\n";
  for (const Number& number : numbers)
    html += "<div>" + HtmlElement("dt", number.name) + HtmlElement("dd", number.value) + "</div>\n";
  return html + "</dl>\n";
}

std::string Warnings(const std::vector<std::string>& texts) {
  if (texts.empty()) return "";
  std::string html = "<ul class=\"warnings\">\n";
  for (const std::string& text : texts) html += HtmlElement("li", text) + "\n";
  return html + "</ul>\n";
}

// Drape coefficients, nodes and outlines of specimens of different sizes cannot be compared.
std::vector<std::string> OtherSizes(const std::vector<ResultFolder>& folders) {
  const ResultFolder* first = nullptr;
  std::vector<std::string> warnings;
  for (const ResultFolder& folder : folders) {
    if (!folder.Discs()) continue;
    if (first == nullptr) first = &folder;
    if (*folder.Discs() != *first->Discs())
      warnings.push_back("The drapes of " + folder.name + " are of specimens of " +
                         ToString(*folder.Discs()) + ", those of " + first->name + " of " +
                         ToString(*first->Discs()) +
                         ": their drape coefficients, nodes and outlines cannot be compared.");
  }
  return warnings;
}

void Append(std::vector<std::string>* all, std::vector<std::string> more) {
  all->insert(all->end(), more.begin(), more.end());
}

// "8.4 (5.3 … 13)": value, factor and unit of a stiffness and its interval; power: of the factor.
std::string WithInterval(double value, double factor, double power = 1.0) {
  const double f = std::pow(factor, power);
  return Format("%.3g (%.3g … %.3g)", value, value / f, value * f);
}

// What the program itself remarks on its results.
std::vector<std::string> Notes(const ResultFolder& folder) {
  std::vector<std::string> notes = FindTexts(folder.summary, "/notes");
  Append(&notes, FindTexts(folder.summary, "/warnings"));
  return notes;
}

std::vector<Number> FitNumbers(const nlohmann::json& s) {
  std::vector<Number> numbers;
  const auto rms = FindNumber(s, "/mean/profile_rms_px"),
             scale = FindNumber(s, "/images/0/camera/px_per_m");
  if (rms && scale)
    numbers.push_back({"outline error, rms", Format("%.2f mm", 1e3 * *rms / *scale)});
  const auto dc = FindNumber(s, "/mean/dc_image"), dc_fit = FindNumber(s, "/mean/dc_fit");
  if (dc && dc_fit)
    numbers.push_back({"drape coefficient, image and fit",
                       Format("%.1f %% and %.1f %%", 100 * *dc, 100 * *dc_fit)});
  if (const nlohmann::json& images = FindList(s, "/images"); images.size() == 1)
    if (const nlohmann::json* photograph = Find(images[0], "/photograph"))
      numbers.push_back({"drape coefficient, photograph", CoefficientText(*photograph) + " %"});
  const auto folds = FindNumber(s, "/mean/folds_image"),
             folds_fit = FindNumber(s, "/mean/folds_fit");
  if (folds && folds_fit)
    numbers.push_back({"nodes, image and fit", Format("%.3g and %.3g", *folds, *folds_fit)});
  const auto bend = FindNumber(s, "/verdict/bend_n_m/value"),
             factor = FindNumber(s, "/verdict/bend_n_m/factor_90");
  const nlohmann::json* determined = Find(s, "/verdict/bend_n_m/determined");
  if (bend && factor && determined != nullptr && *determined == true)
    numbers.push_back(
        {"bending rigidity, 90 % interval", WithInterval(1e6 * *bend, *factor) + " µN·m"});
  const auto directions = FindNumber(s, "/spectrum/determined_directions"),
             count = FindNumber(s, "/parameters/count");
  if (directions && count)
    numbers.push_back(
        {"directions that the data determine", Format("%.0f of %.0f", *directions, *count)});
  return numbers;
}

struct Verdict {
  std::string style, grade, sentence;
};

Verdict FitVerdict(const nlohmann::json& s) {
  const std::string grade = FindText(s, "/verdict/grade");
  if (grade == "good")
    return {"good", "Good",
            std::string(Find(s, "/images") == nullptr
                            ? "The fabric is as the laboratory measured it. "
                            : "Outline, area and nodes are as in the image, at rest and stable. ") +
                "Trust the numbers that are marked as measured, within their intervals."};
  if (grade == "usable")
    return {"usable", "Usable", "Read the warnings before you use these numbers."};
  if (grade.empty()) return {"bad", "No verdict", "The fit has no verdict: it is not complete."};
  return {"bad", "Do not use", "These results are not fit for use, for the reasons below."};
}

std::string VerdictOfFit(const ResultFolder& folder) {
  const Verdict verdict = FitVerdict(folder.summary);
  std::vector<std::string> warnings = FindTexts(folder.summary, "/verdict/reasons");
  Append(&warnings, Notes(folder));
  return "<div class=\"verdict " + verdict.style + "\">" + HtmlElement("h3", folder.name) +
         HtmlElement("p", verdict.grade, "grade") + Warnings(warnings) +
         HtmlElement("p", verdict.sentence) + NumberList(FitNumbers(folder.summary)) + "</div>\n";
}

std::string MeanAndDeviation(const nlohmann::json& feature, double factor, const char* unit) {
  const auto mean = FindNumber(feature, "/mean"), sd = FindNumber(feature, "/sd");
  return mean && sd ? Format("%.3g ± %.2g", factor * *mean, factor * *sd) + unit : "none";
}

// Of drape_validate: which reference cases fail.
std::vector<std::string> FailedCases(const nlohmann::json& s) {
  std::vector<std::string> failed;
  for (const nlohmann::json& one : FindList(s, "/cases"))
    if (const nlohmann::json* pass = Find(one, "/pass"); pass != nullptr && *pass == false)
      failed.push_back("fails: " + FindText(one, "/name"));
  return failed;
}

// Of drape_compare_optimisers: the first of the methods that solve most problems, "lm, 75 %".
std::string BestMethod(const nlohmann::json& s) {
  std::string best;
  double most = -1.0;
  for (const nlohmann::json& method : FindList(s, "/methods"))
    if (const auto share = FindNumber(method, "/solved_at_0.1"); share && *share > most) {
      most = *share;
      best = FindText(method, "/name") + Format(", %.0f %%", 100 * most);
    }
  return best;
}

std::vector<Number> OtherNumbers(const ResultFolder& folder) {
  const nlohmann::json& s = folder.summary;
  std::vector<Number> numbers;
  const auto add = [&](const char* where, const char* name, double factor, const char* unit) {
    if (const nlohmann::json* found = Find(s, where); found != nullptr && found->is_object())
      numbers.push_back({name, MeanAndDeviation(*found, factor, unit)});
    else if (const auto value = FindNumber(s, where))
      numbers.push_back({name, Format("%.4g", factor * *value) + unit});
  };
  if (folder.program != "drape_garment") add("/draws", "drapes", 1, "");
  add("/at_rest", "drapes at rest", 1, "");
  add("/features/dc", "drape coefficient", 100, " %");
  add("/features/folds", "nodes", 1, "");
  add("/spread/dc", "drape coefficient", 100, " %");
  add("/spread/folds", "nodes", 1, "");
  if (folder.program == "drape_photo")
    numbers.push_back({"drape coefficient", CoefficientText(s) + " %"});
  else
    add("/dc", "drape coefficient", 100, " %");
  add("/folds", "nodes", 1, "");
  add("/stability/lowest_frequency_hz", "lowest vibration", 1, " Hz");
  if (folder.program == "drape_bench")
    numbers.push_back({"runs", std::to_string(FindList(s, "/runs").size())});
  add("/runs", "runs", 1, "");
  add("/budget_rollouts", "rollouts for each method and problem", 1, "");
  if (const std::string best = BestMethod(s); !best.empty())
    numbers.push_back({"solves most problems to within 10 %", best});
  if (const nlohmann::json& cases = FindList(s, "/cases"); !cases.empty())
    numbers.push_back({"reference cases that hold",
                       Format("%zu of %zu", cases.size() - FailedCases(s).size(), cases.size())});
  if (const nlohmann::json* counts = Find(s, "/counts"); counts != nullptr && counts->is_object())
    for (const auto& [name, count] : counts->items())
      if (count.is_number() && count.get<double>() > 0) numbers.push_back({name, ValueText(count)});
  return numbers;
}

// What a comparison concludes, in its own words.
std::string Conclusions(const ResultFolder& folder) {
  const std::string file = folder.File("comparison.md");
  if (folder.program != "drape_compare" || !std::filesystem::is_regular_file(file)) return "";
  std::istringstream lines(ReadWholeFile(file));
  std::string html;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("**")) html += HtmlFromMarkdown(line);
  return html;
}

std::string VerdictOfOther(const ResultFolder& folder) {
  static const std::map<std::string, std::string> kPurposes = {
      {"drape_predict", "A prediction: the distribution of the drapes of a fabric."},
      {"drape_simulate", "One drape."},
      {"drape_equilibria", "The stable drapes of one fabric."},
      {"drape_compare", "A comparison of material models on held-out drapes."},
      {"drape_bench", "Cost and accuracy of drapes, derivatives or fits."},
      {"drape_speed", "Time of a step, forward and backward."},
      {"drape_stability", "Where solvers of a drape fail."},
      {"drape_gradients", "Where gradients of a drape fail."},
      {"drape_space", "Distances between fabrics, and their population."},
      {"drape_compare_optimisers", "Optimisers under equal budgets."},
      {"drape_garment", "A moving body in a garment."},
      {"drape_photo", "A photograph of a drape."},
      {"drape_export", "A fabric for other programs."},
      {"drape_metrics", "Measured drapes."},
      {"drape_validate", "Textbook solutions."}};
  const auto purpose = kPurposes.find(folder.program);
  std::string outcome = FindText(folder.summary, "/outcome");
  if (outcome.empty()) outcome = FindText(folder.summary, "/status");
  std::vector<std::string> warnings = Notes(folder);
  Append(&warnings, FailedCases(folder.summary));
  if (outcome == "cancelled") warnings.insert(warnings.begin(), "The run was cancelled.");
  if (const nlohmann::json* failures = Find(folder.summary, "/failures"))
    for (const auto& [reason, count] : failures->items())
      warnings.push_back(ValueText(count) + " drapes: " + reason);
  return "<div class=\"verdict\">" + HtmlElement("h3", folder.name) + Warnings(warnings) +
         HtmlElement("p", purpose == kPurposes.end() ? folder.program : purpose->second) +
         Conclusions(folder) + NumberList(OtherNumbers(folder)) + "</div>\n";
}

// One row of the material, for one fit.
struct Quantity {
  std::string name, value, interval, unit;
  Cell from;
};

void AddEstimate(const nlohmann::json& s, const std::string& where, const char* name, double factor,
                 const char* unit, double power, std::vector<Quantity>* list) {
  const auto value = FindNumber(s, where + "/value"), spread = FindNumber(s, where + "/factor_90");
  if (!value || !spread) return;
  const bool measured = s.at(nlohmann::json::json_pointer(where)).value("determined", false);
  const double v = factor * std::pow(*value, power), f = std::pow(*spread, power);
  list->push_back({name, Format("%.3g", v), Format("%.3g … %.3g", v / f, v * f), unit,
                   OriginCell(measured ? "measured" : "prior")});
}

void AddMean(const nlohmann::json& s, const char* key, const char* name, double factor,
             const char* unit, std::vector<Quantity>* list) {
  const std::string where = std::string("/stiffness/") + key + "/fitted";
  if (const auto value = FindNumber(s, where))
    list->push_back({name,
                     Format("%.3g", factor * *value),
                     "",
                     unit,
                     {"no interval is stored", Cell::Kind::kPrior}});
}

void AddWeight(const nlohmann::json& s, std::vector<Quantity>* list) {
  const auto density = FindNumber(s, "/bending/density_kg_m2");
  if (!density) return;
  const std::string from = FindText(s, "/bending/density_from");
  list->push_back({"mass per area", Format("%.0f", 1e3 * *density), "", "g/m²",
                   from == "given"
                       ? Cell{from}
                       : Cell{"of the start tables: not measured", Cell::Kind::kPrior}});
}

void AddBendingLength(const nlohmann::json& s, std::vector<Quantity>* list) {
  const auto length = FindNumber(s, "/bending/bending_length_m"),
             spread = FindNumber(s, "/verdict/bend_n_m/factor_90");
  const nlohmann::json* determined = Find(s, "/verdict/bend_n_m/determined");
  if (!length || !spread || determined == nullptr) return;
  const double c = 1e2 * *length, f = std::cbrt(*spread);
  list->push_back({"bending length c (ISO 9073-7)", Format("%.3g", c),
                   Format("%.3g … %.3g", c / f, c * f), "cm",
                   OriginCell(*determined == true ? "measured" : "prior")});
}

std::vector<Quantity> ListQuantities(const nlohmann::json& s) {
  std::vector<Quantity> list;
  const std::string bend = "/verdict/bend_n_m";
  AddEstimate(s, bend, "bending rigidity B, as it drapes", 1e6, "µN·m", 1, &list);
  AddEstimate(s, bend, "the same in KES units", 1e6 / kKes, "gf·cm²/cm", 1, &list);
  AddBendingLength(s, &list);
  AddWeight(s, &list);
  AddEstimate(s, "/verdict/stretch_n_per_m", "tensile stiffness, as it drapes", 1, "N/m", 1, &list);
  // A bend row is of an edge: edges along the weft bend the warp.
  AddMean(s, "bend_along_weft_n_m", "bending, warp direction", 1e6, "µN·m", &list);
  AddMean(s, "bend_along_warp_n_m", "bending, weft direction", 1e6, "µN·m", &list);
  AddMean(s, "bend_at_45_deg_n_m", "bending, bias", 1e6, "µN·m", &list);
  AddMean(s, "c11_n_per_m", "tensile stiffness, weft (c11)", 1, "N/m", &list);
  AddMean(s, "c22_n_per_m", "tensile stiffness, warp (c22)", 1, "N/m", &list);
  AddMean(s, "c12_n_per_m", "coupling of warp and weft (c12)", 1, "N/m", &list);
  AddMean(s, "c33_n_per_m", "shear rigidity G (c33/2)", 0.5, "N/m", &list);
  AddMean(s, "c33_n_per_m", "the same in KES units", 0.5 / kKesShear, "gf/(cm·°)", &list);
  return list;
}

std::string Material(const ResultFolder& folder) {
  std::vector<CellRow> rows;
  for (const Quantity& q : ListQuantities(folder.summary))
    rows.push_back({{q.name, Cell::Kind::kHeader},
                    NumberCell(q.value),
                    NumberCell(q.interval),
                    {q.unit},
                    q.from});
  if (rows.empty()) return "";
  return HtmlTable("", {"quantity", "value", "90 % interval", "unit", "where from"}, rows) +
         HtmlElement("p",
                     "Rows without an interval are means of the fitted tables; most of "
                     "their entries are of strains and curvatures that no drape has.",
                     "quiet");
}

// Up to 999,999 without an exponent: "766", "1346", not "1.35e+03".
std::string PlainText(double value, int digits) {
  const double size = std::abs(value);
  const bool whole = size >= std::pow(10, digits) && size < 1e6;
  return Format("%.*g", whole ? 6 : digits, whole ? std::round(value) : value);
}

// "> 20" of a number that is not stored because its instrument reads up to 20.
std::string LaboratoryReading(const nlohmann::json& row, const char* where, int digits) {
  if (const auto value = FindNumber(row, where)) return PlainText(*value, digits);
  const auto most = FindNumber(row, "/reads_up_to");
  return most ? "> " + PlainText(*most, 3) : "none";
}

std::string LaboratoryInterval(const nlohmann::json& row) {
  const bool known =
      FindNumber(row, "/low") && (FindNumber(row, "/high") || FindNumber(row, "/reads_up_to"));
  return known ? LaboratoryReading(row, "/low", 3) + " … " + LaboratoryReading(row, "/high", 3)
               : "";
}

Cell LaboratoryOrigin(const nlohmann::json& row) {
  Cell cell = OriginCell(FindText(row, "/source"));
  if (const std::string note = FindText(row, "/note"); !note.empty()) cell.text += "; " + note;
  return cell;
}

// A table of the readings of each laboratory measurement.
std::string Strips(const nlohmann::json& strips) {
  constexpr std::size_t kMostReadings = 200;
  std::string html;
  for (const nlohmann::json& strip : strips)
    html += HtmlFromObjects(
        FindText(strip, "/name") + ": " + FindText(strip, "/test") +
            Format(", %g degrees from the weft", FindNumber(strip, "/direction").value_or(NAN)),
        FindList(strip, "/points"), kMostReadings);
  return html;
}

std::string Laboratory(const ResultFolder& folder) {
  std::string html;
  if (const nlohmann::json* sheets = Find(folder.summary, "/laboratory");
      sheets != nullptr && sheets->is_object())
    for (const auto& [name, sheet] : sheets->items())
      html += name == "material" ? "" : LaboratoryHtml(sheet);
  const std::string strips = Strips(FindList(folder.summary, "/lab_measurements"));
  if (!strips.empty())
    html += HtmlDetails("Laboratory measurements, and what the fitted fabric gives", strips);
  return html;
}

// Older results have no sheet.
std::string MaterialSheet(const ResultFolder& folder) {
  const nlohmann::json* sheet = Find(folder.summary, "/laboratory/material");
  return sheet == nullptr ? Material(folder) : LaboratoryHtml(*sheet);
}

std::string InWords(const nlohmann::json& s) {
  const nlohmann::json* bend = Find(s, "/verdict/bend_n_m/determined");
  const nlohmann::json* stretch = Find(s, "/verdict/stretch_n_per_m/determined");
  const auto length = FindNumber(s, "/bending/bending_length_m");
  if (bend == nullptr || stretch == nullptr || !length) return "";
  const char* hand = *length < 0.012 ? "soft" : *length < 0.02 ? "of medium stiffness" : "stiff";
  std::string text = *bend == true ? Format(
                                         "The cloth is %s: a strip of it bends under its own "
                                         "weight with a bending length of %.1f cm. ",
                                         hand, 1e2 * *length)
                                   : "The data do not determine how stiff the cloth bends. ";
  text += *stretch == true ? "Stretching is measured as well."
                           : "Stretching and shear are not determined by a drape: those numbers "
                             "come from the prior.";
  return HtmlElement("p", text);
}

}  // namespace

std::string LaboratoryHtml(const nlohmann::json& sheet) {
  std::vector<CellRow> rows;
  for (const nlohmann::json& row : FindList(sheet, "/rows"))
    rows.push_back({{FindText(row, "/name"), Cell::Kind::kHeader},
                    NumberCell(LaboratoryReading(row, "/value", 4)),
                    NumberCell(LaboratoryInterval(row)),
                    {FindText(row, "/unit")},
                    LaboratoryOrigin(row),
                    {FindText(row, "/standard")}});
  if (rows.empty()) return "";
  return HtmlTable(FindText(sheet, "/title"),
                   {"quantity", "value", "90 % interval", "unit", "where from", "standard"}, rows);
}

void AddVerdicts(const std::vector<ResultFolder>& folders, ReportPage* page) {
  std::string html;
  for (const ResultFolder& folder : folders)
    html += folder.IsFit() ? VerdictOfFit(folder) : VerdictOfOther(folder);
  page->AddSection("verdict", "Verdict",
                   Warnings(OtherSizes(folders)) +
                       (folders.size() > 1 ? "<div class=\"side\">\n" + html + "</div>\n" : html));
}

void AddMaterials(const std::vector<ResultFolder>& folders, ReportPage* page) {
  page->AddSection("material", "Material", SideBySide(folders, [](const auto& folder) {
                     const std::string table = folder.IsFit() ? MaterialSheet(folder) : "";
                     return table.empty() ? ""
                                          : InWords(folder.summary) + table + Laboratory(folder);
                   }));
}

}  // namespace drape
