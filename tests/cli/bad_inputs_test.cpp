// Each bad input gives one message with the place, its exit code, and leaves nothing behind.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "gustlab/flight_log.hpp"
#include "support/program.hpp"

namespace gustlab {
namespace bad_inputs_test {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Edit {
  std::string file, from, to;  // from empty: the whole file
};

struct BadInput {
  const char* name;
  int exit_code;
  const char* message;  // how it starts
  std::vector<std::string> arguments;
  std::vector<Edit> edits = {};
};

void PrintTo(const BadInput& bad, std::ostream* out) { *out << bad.name; }

const char* const body_text = R"(<mujoco><worldbody>
<body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.02"/>
<site name="a" pos="1 -1 0"/><site name="b" pos="-1 -1 0"/><site name="c" pos="-1 1 0"/><site name="d" pos="1 1 0"/>
</body></worldbody></mujoco>
)";

const char* const vehicle_text = R"(format = "gustlab-vehicle/1"
name = "quad"
mjcf = "body.xml"
[thrust]
coefficient = 1e-3
torque_ratio = 0.01
max_speed_radps = 200
radius_m = 0.1
[[effect]]
type = "motor_lag"
time_constant = 0.05
[[rotor]]
site = "a"
direction = "ccw"
[[rotor]]
site = "b"
direction = "cw"
[[rotor]]
site = "c"
direction = "ccw"
[[rotor]]
site = "d"
direction = "cw"
)";

const char* const meta_text = R"(format = "gustlab-flight/1"
vehicle = "v/vehicle.toml"
actuator = "rotor_speed"
hold = "zoh"
)";

const char* const with_text = "[[effect]]\ntype = \"rotor_drag\"\nat_hover = 0.3\n";

// two seconds of turning about two axes; which of eight columns hold the quaternion and how fast the rate is said to be
std::string flight_text(bool scalar_last = false, double rate_scale = 1.0) {
  std::string csv = "time_s,px,py,pz,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz,u1,u2,u3,u4\n";
  Quaternion q = Quaternion::Identity();
  for (int k = 0; k < 200; ++k) {
    const Vector3 rate(1.5 * std::sin(0.05 * k), 1.0, 0.5);
    const double c[4] = {q.w(), q.x(), q.y(), q.z()};
    csv += std::to_string(0.01 * k) + ",0,0,1,0,0,0";
    for (int i = 0; i < 4; ++i) csv += "," + std::to_string(c[scalar_last ? (i + 1) % 4 : i]);
    for (int i = 0; i < 3; ++i) csv += "," + std::to_string(rate_scale * rate[i]);
    csv += ",50,50,50,50\n";
    q = q * Quaternion(1.0, 0.005 * rate.x(), 0.005 * rate.y(), 0.005 * rate.z()).normalized();
  }
  return csv;
}

const char* const trials_text = R"(format = "gustlab-trials/1"
name = "t"
vehicle = "v/vehicle.toml"
controllers = ["pid"]
trajectories = ["hover"]
fit = ["hover"]
holdout = ["hover"]
seed = 1
duration_s = 1
[[trial]]
name = "nothing"
)";

const char* const experiment_text = R"(format = "gustlab-experiment/1"
name = "e"
vehicle = "v/vehicle.toml"
trajectories = ["circle"]
controllers = ["pid", "asindy", "indi"]
duration_s = 1
[controller.asindy]
terms = ["1", "theta"]
covariance_law = "printed"
thrust_estimate = "command"
low_level = "auto"
rate_hz = 50
[controller.pid]
feedforward = "none"
rate_hz = 100
[controller.indi]
law = "firmware"
inner = "indi"
[trajectory.circle]
start = "center"
)";
const std::vector<std::string> plan{"sweep", "e.toml", "--dry-run"};

// an edit of one line of the experiment
std::vector<Edit> experiment(const std::string& from, const std::string& to) {
  std::string text = experiment_text;
  return {{"e.toml", "", text.replace(text.find(from), from.size(), to)}};
}

const std::vector<std::string> replay{"replay", "a.csv"}, replay_with{"replay", "a.csv", "--with", "w.toml"};

const BadInput bad_inputs[] = {
    // usage
    {"no command", 2, "gustlab: a command is missing", {}},
    {"unknown command", 2, "gustlab: unknown command \"fly\" (see gustlab --help)", {"fly"}},
    {"command that is nearly one",
     2,
     "gustlab: unknown command \"replya\"; did you mean \"replay\"?",
     {"replya", "a.csv"}},
    {"unknown option",
     2,
     "gustlab: The following argument was not expected: --horizn",
     {"replay", "a.csv", "--horizn", "1"}},
    {"no flight", 2, "gustlab: FLIGHT is required", {"replay"}},
    {"horizons that fall", 2, "--horizon: 0.1 s does not belong there", {"replay", "a.csv", "--horizon", "0.5,0.1"}},
    {"horizon of zero", 2, "--horizon: 0 s does not belong there", {"replay", "a.csv", "--horizon", "0"}},
    {"horizon within a sample",
     3,
     "a.csv: a horizon of 1e-09 s is shorter than a sample of 0.01 s (nothing lies between); ask for 0.01 s or more",
     {"replay", "a.csv", "--horizon", "1e-9"}},
    {"horizon that is a word",
     2,
     "gustlab: --horizon: \"soon\" is no number that it takes",
     {"replay", "a.csv", "--horizon", "soon"}},
    {"negative time",
     2,
     "gustlab: --settle: -1 is not a number from 0 up (see gustlab metrics --help)",
     {"metrics", "a.csv", "--settle", "-1"}},
    {"negative seed", 2, "gustlab: --seed: Value -1 not in range", {"sweep", "ci_small", "--seed", "-1", "--dry-run"}},
    {"seed that is too large",
     2,
     "gustlab: --seed: Value 99999999999999999999 not in range",
     {"sweep", "ci_small", "--seed", "99999999999999999999", "--dry-run"}},
    {"empty word", 2, "gustlab: there is an empty word behind \"sweep\"", {"sweep", "", "--dry-run"}},
    {"empty word of an option",
     2,
     "gustlab: there is an empty word behind \"--with\"",
     {"replay", "a.csv", "--with", ""}},
    {"empty word to an importer", 2, "gustlab: there is an empty word behind \"import\"", {"import", ""}},
    {"name for nothing", 2, "--names =: not a name", {"table", "v", "--names", "="}},
    {"two names for one", 2, "--names pid=B: pid is given twice", {"table", "v", "--names", "pid=A,pid=B"}},
    {"figure twice", 2, "--columns rmse_xy_m: is given twice", {"table", "v", "--columns", "rmse,rmse_xy_m"}},
    {"label of a table without one",
     2,
     "--label: format md has no use for it (it is for latex); leave it out",
     {"table", "v", "--label", "x"}},
    {"label that LaTeX does not take",
     2,
     "--label a}: LaTeX takes no } in a label; letters, digits, _, - and : make one",
     {"table", "v", "--format", "latex", "--label", "a}"}},
    {"best in bold where nothing is bold",
     2,
     "--bold-best: format csv has no use for it (it is for md and latex)",
     {"table", "v", "--format", "csv", "--bold-best"}},
    {"names on a page",
     2,
     "--names: format html has no use for it (it is for md and latex)",
     {"table", "v", "--format", "html", "--names", "pid=X"}},
    {"columns of a whole document",
     2,
     "--columns: format json has no use for it (it is for md, csv and latex)",
     {"table", "v", "--format", "json", "--columns", "rmse"}},
    {"sidecar for a vehicle",
     2,
     "a.meta.toml:1:10: format \"gustlab-flight/1\" is not a vehicle's",
     {"replay", "a.csv", "--vehicle", "a.meta.toml"}},
    {"experiment of no name",
     2,
     "ci_smal: no such file, and no such name under experiments/; did you mean \"ci_small\"?",
     {"sweep", "ci_smal", "--dry-run"}},
    {"folder for an experiment", 2, "v: cannot read (Is a directory)", {"sweep", "v", "--dry-run"}},
    {"empty file for an experiment",
     2,
     "w.toml:1:1: \"format\" is missing",
     {"sweep", "w.toml", "--dry-run"},
     {{"w.toml", "", ""}}},
    {"stride of zero", 2, "gustlab: --stride", {"replay", "a.csv", "--stride", "0"}},
    {"no threads", 2, "gustlab: --jobs", {"replay", "a.csv", "--jobs", "0"}},
    {"unknown format", 2, "gustlab: --format", {"replay", "a.csv", "--format", "xml"}},
    {"unknown rule of a gate",
     2,
     "gustlab: --fails-by: any not in {margin,test,both} (see gustlab gate --help)",
     {"gate", "v", "--baseline", "b.csv", "--fails-by", "any"}},
    {"unknown kind", 2, "gustlab: KIND", {"list", "vehicle"}},
    {"unknown name",
     2,
     "defaults gusts: there is nothing of this name (see `gustlab list`); did you mean \"gust\"?",
     {"defaults", "gusts"}},
    {"number that is none",
     2,
     "gustlab: --settle: nan is not a number from 0 up",
     {"metrics", "a.csv", "--settle", "nan"}},
    {"horizon without end", 2, "--horizon: inf s does not belong there", {"replay", "a.csv", "--horizon", "inf"}},
    {"tolerance that is no number",
     2,
     "gustlab: --margin: nan is not a number from 0 up",
     {"gate", "v", "--baseline", "a.csv", "--margin", "nan"}},
    {"sparsity that is no number",
     2,
     "gustlab: --lambda: nan is not a number from 0 up",
     {"identify", "a.csv", "--lambda", "nan"}},
    {"relaxation without end", 2, "gustlab: --nu: inf is not a number above 0", {"identify", "a.csv", "--nu", "inf"}},
    {"trim below zero", 2, "gustlab: --trim: -1 is not a number from 0 up", {"identify", "a.csv", "--trim", "-1"}},
    {"option of another optimizer",
     2,
     "--max-terms: optimizer sr3 has no use for it (it is for best_subset); leave it out",
     {"identify", "a.csv", "--max-terms", "1"}},
    {"penalty without a use",
     2,
     "--penalty: optimizer stlsq has no use for it",
     {"identify", "a.csv", "--optimizer", "stlsq", "--penalty", "l1"}},
    {"ridge without a use", 2, "--ridge: optimizer sr3 has no use for it", {"identify", "a.csv", "--ridge", "1"}},
    {"window without a use",
     2,
     "--window: derivative finite_difference has no use for it",
     {"identify", "a.csv", "--window", "11"}},
    {"flight replayed twice", 2, "./a.csv: is given twice", {"replay", "a.csv", "./a.csv"}},
    {"log measured twice", 2, "a.csv: is given twice", {"metrics", "a.csv", "a.csv"}},
    {"flight fitted twice", 2, "./a.csv: is given twice", {"identify", "a.csv", "./a.csv"}},
    {"flight fitted and held out", 2, "a.csv: is given twice", {"identify", "a.csv", "--holdout", "a.csv"}},
    // vehicles
    {"unknown vehicle", 2, "unknown vehicle \"crazyfly\"", {"replay", "a.csv", "--vehicle", "crazyfly"}},
    {"missing vehicle file",
     2,
     "no/vehicle.toml: cannot read (No such file or directory)",
     {"replay", "a.csv", "--vehicle", "no/vehicle.toml"}},
    {"vehicle that is not TOML",
     2,
     "v/vehicle.toml:2:8: not TOML (",
     replay,
     {{"v/vehicle.toml", "\"quad\"", "= quad"}}},
    {"unknown key of a vehicle",
     2,
     "v/vehicle.toml:8:1: unknown key \"radius_mm\"; did you mean \"radius_m\"?",
     replay,
     {{"v/vehicle.toml", "radius_m = 0.1", "radius_mm = 100\nradius_m = 0.1"}}},
    {"wrong type in a vehicle",
     2,
     "v/vehicle.toml:5:15: \"coefficient\" must be a number (this is a string)",
     replay,
     {{"v/vehicle.toml", "1e-3", "\"1e-3\""}}},
    {"negative thrust",
     2,
     "v/vehicle.toml:5:15: \"coefficient\" must be positive",
     replay,
     {{"v/vehicle.toml", "1e-3", "-1e-3"}}},
    {"two rotors",
     2,
     "v/vehicle.toml:12:1: 2 rotors",
     replay,
     {{"v/vehicle.toml", "[[rotor]]\nsite = \"c\"\ndirection = \"ccw\"\n[[rotor]]\nsite = \"d\"\ndirection = \"cw\"\n",
       ""}}},
    {"unknown direction",
     2,
     "v/vehicle.toml:17:13: \"left\" is not a direction",
     replay,
     {{"v/vehicle.toml", "\"cw\"", "\"left\""}}},
    {"missing site",
     2,
     "v/vehicle.toml:16:8: there is no site \"e\" in v/body.xml (sites on the vehicle: a, b, c, d)",
     replay,
     {{"v/vehicle.toml", "\"b\"", "\"e\""}}},
    {"MJCF that is not XML", 2, "v/body.xml:", replay, {{"v/body.xml", "</mujoco>", ""}}},
    {"MJCF with a word for a number", 2, "v/body.xml:2", replay, {{"v/body.xml", "mass=\"1\"", "mass=\"heavy\""}}},
    {"MJCF without a free joint",
     2,
     "v/body.xml: a vehicle has exactly one free joint",
     replay,
     {{"v/body.xml", "<freejoint/>", ""}}},
    {"MJCF outside the folder",
     2,
     "v/vehicle.toml:3:8: \"../body.xml\" is outside the vehicle's folder",
     replay,
     {{"v/vehicle.toml", "body.xml", "../body.xml"}}},
    {"unknown effect of a vehicle",
     2,
     "v/vehicle.toml:9:1: unknown effect \"motor_lags\"; did you mean \"motor_lag\"?",
     replay,
     {{"v/vehicle.toml", "motor_lag", "motor_lags"}}},
    {"vehicle that cannot hover",
     2,
     "v/vehicle.toml: the vehicle cannot hover",
     replay,
     {{"v/vehicle.toml", "200", "20"}}},
    // models to compare
    {"missing model", 2, "no.toml: cannot read (No such file or directory)", {"replay", "a.csv", "--with", "no.toml"}},
    {"effect out of range",
     2,
     "w.toml:3:12: \"at_hover\" is out of range (-1 N s/m is not at least 0)",
     replay_with,
     {{"w.toml", "0.3", "-1"}}},
    {"unknown parameter",
     2,
     "w.toml:3:12: unknown key \"at_hovr\"; did you mean \"at_hover\"?",
     replay_with,
     {{"w.toml", "at_hover", "at_hovr "}}},
    {"the same effect twice",
     2,
     "w.toml:4:1: effect \"rotor_drag\" is here twice (first at w.toml:1:1); keep one",
     replay_with,
     {{"w.toml", "", std::string(with_text) + with_text}}},
    {"effect without a type",
     2,
     "w.toml:1:1: \"type\" is missing",
     replay_with,
     {{"w.toml", "type = \"rotor_drag\"\n", ""}}},
    {"term that comes twice",
     2,
     "w.toml:3:9: term \"1\" is here twice",
     replay_with,
     {{"w.toml", "",
       "[[effect]]\ntype = \"sindy_residual\"\nterms = [\"1\", \"1\"]\nfx = [1, 1]\nfy = [1, 1]\nfz = [1, 1]\n"}}},
    {"numbers that are no number per term",
     2,
     "w.toml:4:6: fx must have one number per term (there are 1 terms and 2 numbers)",
     replay_with,
     {{"w.toml", "", "[[effect]]\ntype = \"sindy_residual\"\nterms = [\"1\"]\nfx = [1, 1]\nfy = [1]\nfz = [1]\n"}}},
    {"rotor that is not there",
     2,
     "w.toml:3:9: rotor_loss: no rotor 5 (the vehicle has 4); use 1 to 4",
     replay_with,
     {{"w.toml", "", "[[effect]]\ntype = \"rotor_loss\"\nrotor = 5\n"}}},
    // experiments: what only its owner knows of a parameter is said with its place, too
    {"unknown term", 2, "e.toml:8:9: term \"thata\": unknown variable \"thata\"", plan, experiment("theta", "thata")},
    {"terms that are none", 2, "e.toml:8:9: \"terms\" has 0 terms", plan, experiment("[\"1\", \"theta\"]", "[]")},
    {"unknown covariance law", 2, "e.toml:9:18: covariance_law = \"printd\" is unknown", plan,
     experiment("printed", "printd")},
    {"unknown thrust estimate", 2, "e.toml:10:19: thrust_estimate = \"comand\" is unknown", plan,
     experiment("command", "comand")},
    {"unknown loops", 2, "e.toml:11:13: low_level = \"px4\" is unknown", plan, experiment("auto", "px4")},
    {"rate that divides nothing", 2, "e.toml:12:11: rate_hz = 333 does not divide the base rate of 500 Hz", plan,
     experiment("50", "333")},
    {"unknown feed-forward", 2, "e.toml:14:15: feedforward = \"some\" is unknown", plan,
     experiment("\"none\"", "\"some\"")},
    {"rate of a firmware that divides nothing", 2, "e.toml:15:11: rate_hz = 7 does not divide", plan,
     experiment("100", "7")},
    {"unknown law", 2, "e.toml:17:7: law = \"x\" is unknown", plan, experiment("\"firmware\"", "\"x\"")},
    {"unknown inner loop", 2, "e.toml:18:9: inner = \"x\" is unknown", plan, experiment("\"indi\"\n[tr", "\"x\"\n[tr")},
    {"unknown start", 2, "e.toml:20:9: start = \"x\" is unknown", plan, experiment("center", "x")},
    {"rate on the command line",
     2,
     "--set controller.pid.rate_hz=7: rate_hz = 7 does not divide",
     {"sweep", "e.toml", "--dry-run", "--set", "controller.pid.rate_hz=7"},
     experiment("100", "100")},
    {"model without terms",
     2,
     "e.toml:8:9: w.toml has 0 terms",
     plan,
     {experiment("terms = [\"1\", \"theta\"]", "model = \"w.toml\"")[0],
      {"w.toml", "", "[[effect]]\ntype = \"sindy_residual\"\n"}}},
    {"empty file for effects",
     2,
     "w.toml:1:1: there is no [[effect]] (nothing to compare); name the augmented.toml of a diagnosis",
     replay_with,
     {{"w.toml", "", ""}}},
    {"remark for effects", 2, "w.toml:1:1: there is no [[effect]]", replay_with, {{"w.toml", "", "# none\n"}}},
    {"unknown key beside effects",
     2,
     "w.toml:1:3: unknown key \"efect\"; did you mean \"effect\"?",
     replay_with,
     {{"w.toml", "effect", "efect"}}},
    // recordings
    {"missing flight", 3, "b.csv: cannot read (No such file or directory)", {"replay", "b.csv"}},
    {"missing flight to verify on",
     3,
     "b.csv: cannot read (No such file or directory)",
     {"diagnose", "a.csv", "--holdout", "b.csv", "--out", "d"}},
    {"flight given twice", 2, "a.csv: is given twice", {"diagnose", "a.csv", "a.csv", "--out", "d"}},
    {"flight that is fitted and held out",
     2,
     "./a.csv: is given twice",
     {"diagnose", "a.csv", "--holdout", "./a.csv", "--out", "d"}},
    {"flight that is its own reference",
     2,
     "a.csv: is given twice",
     {"diagnose", "a.csv", "--reference", "a.csv", "--out", "d"}},
    {"quiet and verbose", 2, "gustlab: --quiet excludes --verbose", {"run", "e.toml", "--out", "d", "-q", "-v"}},
    {"folder of a flight", 3, "v: not a flight log", {"replay", "v"}},
    {"negative replicate",
     2,
     "gustlab: --replicate: \"-3\" is no number that it takes",
     {"run", "e.toml", "--replicate", "-3", "--out", "d"}},
    {"replicate that is not planned",
     2,
     "--replicate 2: not in this experiment (it has 1); plan it with --set first_replicate and replicates",
     {"run", "e.toml", "--controller", "pid", "--replicate", "2", "--out", "d"},
     {{"e.toml", "", experiment_text}}},
    {"replicate before the first",
     2,
     "--replicate 0: not in this experiment (it has 5 to 6)",
     {"run", "e.toml", "--controller", "pid", "--replicate", "0", "--out", "d", "--set", "first_replicate=5", "--set",
      "replicates=2"},
     {{"e.toml", "", experiment_text}}},
    {"key that is set twice",
     2,
     "--set seed=2: seed is set twice (--set seed=1 would be lost); leave one out",
     {"sweep", "e.toml", "--dry-run", "--set", "seed=1", "--set", "seed=2"}},
    {"part of a key that is set",
     2,
     "--set controller.pid.rate_hz=50: controller.pid.rate_hz is set twice",
     {"sweep", "e.toml", "--dry-run", "--set", "controller.pid={rate_hz=100}", "--set", "controller.pid.rate_hz=50"}},
    {"key of an option that is set, too",
     2,
     "--set seed=1: seed is set twice (--seed says it, too); leave one out",
     {"sweep", "e.toml", "--dry-run", "--set", "seed=1", "--seed", "2"}},
    {"key of trials that is set twice",
     2,
     "--set duration_s=3: duration_s is set twice",
     {"conceal", "t.toml", "--out", "d", "--answers", "x.toml", "--set", "duration_s=2", "--set", "duration_s=3"}},
    {"standard output for a folder",
     2,
     "-: is the standard output, not a folder; name a folder (./- is one of this name)",
     {"vehicle", "new", "--mass", "1.2kg", "--arm", "0.25m", "--prop", "10in", "--thrust-to-weight", "2.1", "--out",
      "-"}},
    {"standard output for the folder of a sweep",
     2,
     "-: is the standard output, not a folder",
     {"sweep", "e.toml", "--out", "-"},
     {{"e.toml", "", experiment_text}}},
    {"command of a group is missing", 2, "gustlab: a command is missing (see gustlab vehicle --help)", {"vehicle"}},
    {"name of a file without its ending",
     2,
     "w: no such file, and no such name under experiments/; did you mean \"w.toml\"?",
     {"sweep", "w", "--out", "d"},
     {{"w.toml", "", ""}}},
    {"answers that are none", 3, "w.toml: no answers", {"score", "w.toml", "v"}, {{"w.toml", "", ""}}},
    {"weights that cannot be written", 2, "v: cannot write (Is a directory)", {"train", "collect_iris", "--out", "v"}},
    {"answers that cannot be written",
     2,
     "v: cannot write (Is a directory)",
     {"conceal", "w.toml", "--out", "d", "--answers", "v"},
     {{"w.toml", "", trials_text}}},
    {"gains in a file",
     2,
     "a.csv: cannot make this folder (a.csv is a file, not a folder)",
     {"tune", "fair_link", "--out", "a.csv"}},
    {"calibration in a file",
     2,
     "a.csv: cannot make this folder (a.csv is a file, not a folder)",
     {"calibrate", "table1_iris", "--out", "a.csv"}},
    {"one experiment for all tables",
     2,
     "--experiment stands for one table",
     {"reproduce", "all", "--experiment", "iris_causes", "--out", "out"}},
    {"not a flight's name",
     3,
     "w.toml: not a flight log (its name must end with .csv or .csv.gz)",
     {"replay", "w.toml"}},
    {"sidecar of something else",
     3,
     "a.meta.toml:1:10: format \"other/1\" is not a flight log's",
     replay,
     {{"a.meta.toml", "gustlab-flight/1", "other/1"}}},
    {"unknown actuator",
     3,
     "a.meta.toml:3:12: \"rotor_sped\" is not one of",
     replay,
     {{"a.meta.toml", "rotor_speed", "rotor_sped"}}},
    {"unknown key of a sidecar",
     3,
     "a.meta.toml:4:1: unknown key \"hould\"; did you mean \"hold\"?",
     replay,
     {{"a.meta.toml", "hold", "hould"}}},
    {"empty flight", 3, "a.csv:1:1: the file is empty", replay, {{"a.csv", "", ""}}},
    {"flight without samples",
     3,
     "a.csv: the log is empty (0 samples)",
     replay,
     {{"a.csv", "", "time_s,px,py,pz,u1\n"}}},
    {"flight with NaN",
     3,
     "a.csv:2:18: \"nan\" in column vy is not a finite number",
     replay,
     {{"a.csv", "1,0,0,0,", "1,0,nan,0,"}}},
    {"flight with a word",
     3,
     "a.csv:2:18: \"fast\" in column vy is not a number",
     replay,
     {{"a.csv", "1,0,0,0,", "1,0,fast,0,"}}},
    {"row that is too short", 3, "a.csv:2:", replay, {{"a.csv", "1,0,0,0,", "1,0,0,"}}},
    {"time that falls", 3, "a.csv:4:1: time does not rise", replay, {{"a.csv", "\n0.020000", "\n0.005000"}}},
    {"flight without time", 3, "a.csv:1:1: column \"time_s\" is missing", replay, {{"a.csv", "time_s", "t"}}},
    {"flight without inputs",
     3,
     "a.csv:1:1: there is no actuator input",
     replay,
     {{"a.csv", "u1,u2,u3,u4", "a,b,c,d"}}},
    {"missing rotor's input",
     3,
     "a.csv:1:53: column \"u3\" is here and \"u2\" is not",
     replay,
     {{"a.csv", "u1,u2,", "u1,v2,"}}},
    {"column twice", 3, "a.csv:1:11: column \"px\" is here twice", replay, {{"a.csv", "px,py", "px,px"}}},
    {"quaternion that is no rotation",
     3,
     "a.csv:2:22: the quaternion's norm is 2",
     replay,
     {{"a.csv", "1.000000,0.000000", "2.000000,0.000000"}}},
    {"flight without attitude", 3, "a.csv: cannot be replayed", replay, {{"a.csv", "qw", "q0"}}},
    {"flight that is too short",
     3,
     "a.csv: no unbroken stretch of 5 s to replay",
     {"replay", "a.csv", "--horizon", "5"}},
    {"smoothing longer than the flight",
     3,
     "a.csv: no usable stretch is left (fewer than 201 samples in a row",
     {"identify", "a.csv", "--smooth", "201"}},
    {"flight without a reference",
     3,
     "a.csv:1:1: column \"rpx\" is missing (a tracking error needs position and reference)",
     {"metrics", "a.csv"}},
    {"inputs of fewer rotors",
     3,
     "a.csv: no actuator input for 4 rotors",
     replay,
     {{"a.csv", "u1,u2,u3,u4", "u1,u2,u3,x4"}}},
};

class BadInputs : public ::testing::TestWithParam<BadInput> {};

std::map<std::string, std::string> everything_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    all[entry.path().string()] = entry.is_regular_file() ? read_text(entry.path()) : "";
  return all;
}

TEST_P(BadInputs, AreSaidInOneLineAndLeaveNothing) {
  const BadInput& bad = GetParam();
  const TemporaryFolder folder;
  folder.write("v/body.xml", body_text);
  folder.write("v/vehicle.toml", vehicle_text);
  folder.write("a.meta.toml", meta_text);
  folder.write("a.csv", flight_text());
  folder.write("w.toml", with_text);
  for (const Edit& edit : bad.edits) {
    std::string text = edit.from.empty() ? edit.to : read_text(folder.file(edit.file));
    if (!edit.from.empty()) {
      const std::size_t at = text.find(edit.from);
      ASSERT_NE(at, std::string::npos) << edit.from;
      text.replace(at, edit.from.size(), edit.to);
    }
    folder.write(edit.file, text);
  }
  const auto before = everything_in(folder.path());
  const test::Said said = test::gustlab(bad.arguments, folder.path().string());
  EXPECT_EQ(said.exit_code, bad.exit_code) << said.err;
  EXPECT_EQ(said.out, "");
  // warnings may come first; the last line is the message, and the only one
  EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1 + (said.err.starts_with("warning: ") ? 1 : 0))
      << said.err;
  const std::size_t message = said.err.starts_with("warning: ") ? said.err.find('\n') + 1 : 0;
  EXPECT_THAT(said.err.substr(message), StartsWith(bad.message));
  EXPECT_EQ(everything_in(folder.path()), before);
}

INSTANTIATE_TEST_SUITE_P(All, BadInputs, ::testing::ValuesIn(bad_inputs), [](const auto& bad) {
  std::string name = bad.param.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

TEST(BadInputs, GoodInputOfTheSameKindIsTaken) {
  const TemporaryFolder folder;
  folder.write("v/body.xml", body_text);
  folder.write("v/vehicle.toml", vehicle_text);
  folder.write("a.meta.toml", meta_text);
  folder.write("a.csv", flight_text());
  folder.write("w.toml", with_text);
  const test::Said said = test::gustlab({"replay", "a.csv", "--with", "w.toml"}, folder.path().string());
  EXPECT_EQ(said.exit_code, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("position_m"));
  EXPECT_EQ(said.err, "");
  folder.write("e.toml", experiment_text);
  EXPECT_EQ(test::gustlab({"sweep", "e.toml", "--dry-run"}, folder.path().string()).exit_code, 0);
}

}  // namespace bad_inputs_test
}  // namespace gustlab
