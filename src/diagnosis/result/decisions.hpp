// The table of decisions: every threshold that decides a name, an alarm or a verdict. Each entry says the statistic that is compared with it,
// what the value was derived from or measured on ("no derivation": it was chosen and not measured), and what it costs. Numbers of a
// method (windows, steps, grids, priors of a fit) stand where they are used; tests/layers/test_decisions.py knows them. Faults of a log
// are judged in recording/, the weights of evidence in evidence/judge.cpp. Costs are measured by scripts/prove/threshold_costs.py (docs/proof/thresholds.md).
#pragma once

#include <cstddef>

namespace gustlab::diagnosis::decisions {

// ---- blocks

// Length of a block, s: of Gram matrices, regimes, dependence, plots of residuals and hover balances.
// Statistic: correlation time of what nothing explains. From: some correlation times of a calm room's air (0.2 s), so that blocks hardly
// depend on each other. Costs: what changes within a block is one value.
inline constexpr double block_s = 0.5;

// ---- reading and alignment

// Names are only suspected where commands jitter so much and the log does not say how they are held.
// Statistic: share of the variance of the commanded torque that is white from sample to sample. From: real logs 0.00 to 0.15; a 500 Hz loop
// with a noisy gyroscope that was logged at 100 Hz 0.4 to 0.7. Costs: not measured.
inline constexpr double most_command_jitter = 0.25;
// A loop that runs its rotors from one limit to the other is out of control: it shows that rotors answer late, and nothing else.
// Statistic: share of the commands at the highest, or at the lowest, of their flight, the smaller of the two. From: .29 to .89 in eleven simulated flights that a delay of
// 30 ms made unstable, of which each had a wrong name; at most .02 in 72 recorded and 900 simulated flights. Costs: none were seen.
inline constexpr double most_at_both_limits = 0.1;
// Commands of one flight are read later when its own likelihood rises so much, and no more at half and at one and a half of it, and that of the
// promptest flight falls.
// Statistic: twice the log likelihood; difference of two delays in samples. From: three standard deviations for the fall; no derivation for the
// rise and the samples. Costs: smaller offsets between clocks stay, and look like a delay of part of the flights.
inline constexpr double least_offset_gain = 100.0, least_offset_loss = 9.0, least_offset_samples = 0.6;

// ---- noise

// Errors of the sensors last: correlation of innovations from sample to sample, and what a memory of its own gains.
// Statistic: correlation; twice the log likelihood per innovation. From: white errors correlate up to 0.05 and gain 0.012 in slow flight; interpolated
// poses gain 0.66. Costs: errors that last less are charged to the vehicle as a disturbance.
inline constexpr double lasting_correlation = 0.1, lasting_gain = 0.03;
// The disturbance is never believed to be smaller than this share of a calm room's.
// Statistic: its standard deviation. From: below it the difference of two right integrators was named. Costs: effects that only a calmer
// room would show.
inline constexpr double least_share_of_floor = 0.35;
// The recorded loop answers what disturbs a smoothed flight: what only the torque per command shows is not identifiable then.
// Statistic: share of the slow commanded torque of an axis in what the nominal vehicle leaves half a second ahead; -1: all of it is
// cancelled. From: -0.65 to -0.74 (a racer, NeuroBEM), -0.55 to -0.62 (nanodrone, roll and pitch); trials of a foreign generator that were
// filtered at 14 to 22 Hz have -0.26 to 0.05. Costs: inertia and torque ratios of such logs; one that is 0.6 of the file's looks so as well.
inline constexpr double answered_share = -0.4;
// Commands predict measured rotor speeds where they leave no more than this.
// Statistic: share of the variance of the speeds' changes. From: no derivation. Costs: beyond it lags show in the body alone.
inline constexpr double most_speed_left = 0.25;
// What reference flights do not show is known as if the file were right to one natural size.
// Statistic: information in natural sizes. From: no derivation. Costs: a file that is wrong by more is followed only in part.
inline constexpr double reference_prior = 1.0;
// What a flight turns more than others by is usually as large as a centre of mass that moved by so much from flight to flight makes it.
// Statistic: share of an arm; counts as one flight more among those that say how large it is. From: 0.3 mm of a Crazyflie (imrc: 0.5 mm in
// one flight of five); a foreign trial in which nothing was concealed had a centre of mass of 0.3 mm with a gain of 1,528 without it, and 60
// with it. Costs: not measured; a centre of mass below some 0.5 mm of a Crazyflie is not told by three flights.
inline constexpr double usual_shift = 0.003;

// ---- selection

// What a further effect must gain beyond the price of its numbers, as a share of the whole gain, and at most as a share of the degrees of freedom.
// Statistic: Δχ². From: no derivation of the values; the first keeps the second-order error of a giant effect out, and is bounded where the
// model was linearised about that effect. Costs: smaller effects are not looked at; the judge withdraws what is let in too much.
inline constexpr double relative_materiality = 1e-4, most_materiality = 0.003;
// A chosen effect is not zero.
// Statistic: Wald test with clustered errors, over the number of groups. From: one false effect in a thousand searches (Bonferroni). Costs:
// effects below some four standard errors.
inline constexpr double wald_p = 0.001;
// A history is tried: a load that explains so much, a speed limit that gains so much and is so near to what its column says.
// Statistic: share of the horizontal disturbance; Δχ²; coefficient of the column (1: exactly that limit); samples at the limit. From: no derivation.
// Costs: lighter loads and limits that are seldom reached are not looked at.
inline constexpr double least_load_share = 0.01, least_limit_delta_chi2 = 30.0, least_limit_strength = 0.2,
                        fewest_limited_samples = 10.0;
// What a history costs in the search, beyond its column: numbers that were fitted to it beforehand.
// Statistic: parameters. From: length, damping and the swing of some flights; a limit out of twenty. Costs: histories that gain less.
inline constexpr double swing_costs = 30.0, limit_costs = 5.0;
// A number that is known beforehand ran away from it: it stands in for something else, and stays as the vehicle file has it.
// Statistic: its change over what it is known to. From: two standard deviations; the height of the centre of mass stood for a moment of the
// velocity (nanodrone, NeuroBEM, imrc). Costs: a centre of mass that is a tenth of an arm higher or lower, and a steady wind of 2 m/s
// up or down, are not named.
inline constexpr double ran_away = 2.0;
// A number of an effect that has several is not identifiable from the flights, and not asked.
// Statistic: its standard error, all else known, over half the width of what is plausible. From: a moment of inertia in yaw, in flights that keep their heading,
// has 0.45 to 1.0, those in roll and pitch of the same flights 0.01 to 0.03, a wind up or down 0.2. Costs: numbers known so badly.
inline constexpr double unidentifiable_share = 0.25;
// A value is a trim, no missing physics: up to so many tolerances.
// Statistic: the larger of its sizes in reporting tolerances. From: an estimate holds a share of what alike parts scatter; no
// derivation of the value. Costs: effects between one tolerance and this.
inline constexpr double scatter_margin = 1.2;
// By means of torques a rotor's loss is no shifted centre of mass where it changes the total thrust by so much.
// Statistic: change over the reporting tolerance of the thrust. From: untouched flights of Neural-Swarm have an offset of the centre of mass that a rotor with 7 %
// more thrust would make as well (1.5). Costs: losses below a tenth, of one rotor of four, are at best suspected in such logs.
inline constexpr double thrust_tells_rotor = 2.0;
// Against reference flights a smaller change is none.
// Statistic: change over what the reference flights have. From: rotor drag of one Crazyflie between its flights, 9 to 13 % (imrc, bare). Costs: smaller
// changes of such a number.
inline constexpr double same_again_share = 0.1;
// Against reference flights that have a force or a wind of their own each, one of that kind is none up to so many of their sizes (rms).
// Statistic: value over the rms of the reference flights. From: three standard deviations; a Crazyflie whose flights each show a constant
// force of 3 to 5 % of its weight (nanodrone). Costs: a wind that is less than that many times what the reference flights had.
inline constexpr double same_again_scatter = 3.0;
// A lag or delay below so many samples is a convention of the log, where it does not say how commands are held.
// Statistic: delay in samples. From: a mean over an interval, stamped at its end, reads 0.62 samples late; a staircase that is read as a straight line, beside measured
// rotor speeds, 0.95 to 1.07 (measured). Costs: delays of a sample.
inline constexpr double unknown_hold_samples = 1.0;
// Where a log does not say how commands go on between its rows, measured rotor speeds jump to the commands of their rows when that leaves so much less.
// Statistic: share of the variance of the roll and pitch acceleration from row to row that is left, over that which straight lines leave. From: simulated logs of 50 and 100 Hz of
// loops at 500 Hz: 0.00 to 0.16 without noise where rotors obey at once, 0.6 to 0.8 with noise, 150 with a lag. Costs: not measured.
inline constexpr double left_by_jumps = 0.9;

// Where a log says that commands are held, measured speeds are known between its rows where the vehicle file's rotors leave less than this of what they change from
// row to row. Statistic: Σ (speed of the next row − predicted)² over Σ (change of the speed)². From: simulated logs at the loop's rate. Costs: not measured.
inline constexpr double left_by_answers = 0.01;
// Where a log does not say how commands go on between its rows, a name stands for physics when it stays as large with every other row alone.
// Statistic: relative change of its size. From: simulated logs of 50 and 100 Hz of faster loops: of 126 right names (lags and delays apart) one changes by .37 and
// the others by .29 at most, of 32 wrong ones 15 by more. Costs: sizes that only the fastest motion shows.
inline constexpr double same_at_half_rate = 1.0 / 3.0;
// A loop goes on between the commands of the rows, where the body turns further between them than the rates on them say, by the commands.
// Statistic: share of the turn, and how many of its standard errors. From: simulated logs of loops at 500 Hz that set new attitudes at 50 Hz on the rows: 0.007 at 50 Hz,
// where commands show a quarter more torque than there is, 0.0015 at 100 Hz (a tenth). Costs: moments of inertia in roll and pitch of such logs.
inline constexpr double least_turn_between_rows = 5e-4, turn_between_rows_errors = 3.0;
// A gyroscope that reads less stands for physics where it is so many times what the body turned further between such rows.
// Statistic: share of the turn, over its share by the commands. From: as above. Costs: small scales of such logs.
inline constexpr double most_of_turns_between_rows = 2.0;
// A lag or delay up to here may be a filter's, in logs that were low-pass filtered while their commands were not.
// Statistic: difference from the vehicle file, s. From: up to 30 ms were named on filtered flights without any. Costs: lags up to there on such logs.
inline constexpr double filter_lag_s = 0.03;
// A gyroscope's scale up to here may be the filters', in logs that were low-pass filtered, each column differently.
// Statistic: difference from the vehicle file. From: Butterworth filters of second order, forward and back, of 12 Hz (attitude) and 18 Hz (rates) differ so much
// at 6 Hz; untouched flights of NeuroBEM show .027. Costs: scales up to there on such logs.
inline constexpr double filter_rate_share = 0.05;
// Where rotor speeds are measured, the search begins at a lag or a delay with which commands predict them so much better.
// Statistic: rms of what is not predicted, over that without. From: 0.3 for a lag of 67 ms (imrc, brushed); no derivation. Costs: it is a beginning only.
inline constexpr double latency_shows = 0.8;
// A lag of the rotors is told from a delay where commands predict measured speeds so much better with it; where not better at all, neither is named.
// Statistic: rms of what is not predicted of held-out flights, over that without. From: 24 right ones in simulated flights have 0.00 to 0.38; two lags in place of
// a delay 0.73 and 0.99, one in place of nothing 1.03. Costs: a class of two where a small lag is beside commands that jitter.
inline constexpr double latency_told = 0.6;
// Where they are not, it begins at a lag or a delay with which the motion is so much likelier.
// Statistic: sum of the whitened squares, sensors' biases fitted, over that without. From: .965 for a delay of 28 ms, .83 for a lag of 90 ms (imrc); no derivation.
// Costs: it is a beginning only.
inline constexpr double latency_likelier = 0.98;
// Trims beside everything imitate an effect: how much they scatter, and what that may cost; beside the omnibus bases they scatter more.
// Statistic: standard deviation in reporting tolerances; Δχ². From: no derivation for the shares; three standard deviations for the cost. Costs: effects
// that scatter of everything else could be.
inline constexpr double trim_share = 0.25, trim_cost = 9.0, scatter_share = 0.5;
// Of sets that fit alike, another one is taken when it says so much less.
// Statistic: sum of sizes in tolerances squared, each at most 1. From: no derivation. Costs: none known.
inline constexpr double least_said_less = 0.1;
// A force of each flight is taken for a number of the vehicle that loses no more, beyond what its fewer numbers cost less.
// Statistic: share of the force's Δχ². From: no derivation. Costs: forces that are upward and alike in all flights.
inline constexpr double nearly_all = 0.05;
// A candidate is equal to a rival.
// Statistic: paired differences of blocks, in standard errors; share of the effect's own gain that the rival loses. From: p = 0.01 for the first, no
// derivation for the second. Costs: names that are known more weakly are given as a class.
inline constexpr double equivalent_z = 2.6, most_lost_to_rival = 0.5;
// A rival that costs no more than this is told by no flight, however sure its sign: a mass and a thrust scale differ by how the loop answers the gyroscope's
// noise, and no model of an effect is right to 3 % of its size.
// Statistic: Δχ², and its share of what the effect itself gains. From: odds of 150 to one; the square of 3 %. Costs: strong names that are known so
// closely are given as a class.
inline constexpr double least_told_chi2 = 10.0, least_told_share = 1e-3;
// Of two equal names the one with the far more usual size is said.
// Statistic: sizes in those that are typical of each effect: the name's, at least so much; the other's, as a share of it. From: no derivation. Costs: a
// right name of an unusual size is said second, in its class.
inline constexpr double unusual_from = 3.0, far_more_usual = 0.5;
// Of a moment of inertia that a torque ratio may be as well.
// Statistic: its relative change, at least so much. From: the reporting tolerance of inertia. Costs: none known.
inline constexpr double least_aliased = 0.05;

// ---- size and error of what is named

// No effect is exactly its formula; no cable is exactly as long as sampled accelerations say.
// Statistic: share of the value that is added to its standard error. From: intervals of drag-like effects covered 31 to 67 % at nominal 95 % without;
// ten trials of the independent reality for the cable. Costs: wider intervals of everything else.
inline constexpr double model_form = 0.03, cable_form = 0.005;
// These flights hardly show an effect.
// Statistic: strength in natural sizes that would be five standard errors. From: no derivation. Costs: a remark, no name.
inline constexpr double hardly_shown = 6.0;

// ---- evidence

// A candidate is named, suspected, or withdrawn at once with the others that are hopeless.
// Statistic: probability by its record (evidence/judge.cpp). From: of the names from 0.8 on 95 % are true on the data of the fit, of those between 0.5 and
// 0.8 73 %; no derivation for hopeless. Costs: docs/proof/judge.md.
inline constexpr double named_from = 0.8, suspected_from = 0.5, hopeless = 0.043;
// With a name rollouts are worse.
// Statistic: share of their error half a second ahead. From: of eleven wrong names of recorded flights that this alone holds down the least is 0.086, of
// three right ones 0.007, 0.008 and 0.033 (docs/proof/judge.md). Costs: a name that harms by less is not doubted for it.
inline constexpr double least_loss = 0.01;
// While names are judged together a candidate stays beside the others from here on.
// Statistic: probability by its record. From: what others take from it may come back when they have gone; it is one half before it is stretched
// (evidence/judge.cpp), as hopeless is a tenth; no derivation. Costs: a candidate that is
// rejected in the end may hold what another one needs.
inline constexpr double stays_from = 0.414;
// What reference flights show stays from here on.
// Statistic: probability by its record. From: what is left out comes back as a change, and so does what should have been left out: a rotor of NeuroBEM that
// pushes 8 % more (.08) made a moment of velocity a change (.94) where nothing was changed; a lag of Neural-Swarm that went with .4 came back. Costs: few
// names lie between.
inline constexpr double reference_stays_from = 0.1;
// A name gains far more than another one, and is left beside it where the other is asked what it gains by itself.
// Statistic: ratio of Δχ². From: two that undo each other gain alike; a thrust scale beside a moment, a drag and an inflow of nanodrone that gain 3 to
// 40 times as much. Costs: docs/decisions/59.
inline constexpr double far_more = 2.0;
// Rollouts need a finding: where it does not stand, its nearest rival is asked in its place.
// Statistic: errors half a second ahead without it, less those with it, in standard errors. From: p = 0.02. Costs: not measured.
inline constexpr double surely_needed = 2.0;
// A moved signature is another one.
// Statistic: mean square correlation of a signature with itself, moved. From: no derivation. Costs: effects that are alike everywhere have no
// such null.
inline constexpr double most_alike = 0.7;
// A force of every flight's own counts in units of what a frame that is not level leaves of gravity.
// Statistic: rms of its acceleration over g. From: 0.6 degrees; no derivation. Costs: winds and forces below two to four hundredths of the weight are
// named less surely.
inline constexpr double level_share = 0.01;
// In a flight that keeps its heading a wind or a force of its own looks like an attitude that is off.
// Statistic: length of the mean heading; rms of its acceleration over g. From: 26 real flights of six families have 0.99 to 1.00; motion capture takes a body
// as it stood when it was defined (NanoBench, indoors: 1.0 and 3.1 degrees); no derivation for four degrees. Costs: where the heading stays, winds below some
// five hundredths of the weight are only suspected.
inline constexpr double kept_heading = 0.97, tilt_share = 0.07;
// A size differs along a variable.
// Statistic: probability by chance, of as many variables as there are. From: four tethers that were named constant forces, 4e-5 to 4e-9; of 79 other
// constant forces and winds a dozen are below it, which differ by .12 at most. Costs: what is less sure is not doubted.
inline constexpr double uneven_p = 0.005;
// A size that differs that much along a flight is doubted: of what nothing in flight changes, of the airframe (a centre of mass, an inertia, one rotor),
// of a law of thrust, of others.
// Statistic: standard deviation of a size between regimes beyond its errors, over the size. From: of 67 right masses and forces and 41 lags and delays the
// largest is .18 and .14, of their wrong names the least .18; right numbers of the airframe have .08 at most (14 recorded cases), nine wrong ones .12 to
// .25; four vortex rings that were a thrust curve or a battery have .53 to 1.24, right ones .39 at most; others are right up to .77 (a thrust scale of
// nanodrone) and wrong from 1.14. Costs: nanodrone's translational lift (1.04) is less sure.
inline constexpr double constant_differs = 0.13, airframe_differs = 0.1, law_differs = 0.4, other_differs = 0.8;
// Force against moment: a force that would be seen.
// Statistic: χ² of the force, and its share of what the effect gains. From: five standard deviations; rotor drag of a Crazyflie (imrc, brushless), whose moment
// has between a fiftieth and a twentieth of its Δχ²; an inflow of the simulator, whose air turns nothing: 0.027 and 0.059. Costs: what is not
// compared is not doubted.
inline constexpr double least_force_seen = 25.0, least_force_share = 0.02;

// ---- what is left

// More than chance in a family of generic functions.
// Statistic: Δχ² beyond its degrees of freedom, in their standard deviations, and as a share of all information. From: clean flights gave 70 to 105 on 51
// and 21 to 44 on 24 degrees of freedom (limits 112 and 66); no derivation for the share. Costs: not measured by itself.
inline constexpr double beyond_chance_sd = 6.0, beyond_chance_share = 0.001;
// A channel belongs to an alarm of several; a channel, or how late rotors and pose are, to what is located.
// Statistic: its gain as a share of the largest. From: no derivation. Costs: channels that are disturbed little are not said.
inline constexpr double least_channel_of_alarm = 0.25, least_channel = 0.02, least_timing = 0.3;
// Where a channel's rest stands.
// Statistic: share of its variance that a variable explains, beside the same series moved. From: no derivation. Costs: weaker dependence is not said.
inline constexpr double least_where = 0.1;
// Innovations are not white.
// Statistic: largest autocorrelation over 25 lags; where errors of the sensors last, colour that one correlation time does not follow is theirs. From:
// clean flights up to 0.09, unknown physics 0.2 to 0.5; no derivation for the second. Costs: unknown physics between.
inline constexpr double most_correlation = 0.15, most_correlation_of_lasting = 0.3;
// Disturbed more than a calm room.
// Statistic: disturbance, or what of it lasts, over the reference floor. From: no derivation (see decision 22). Costs: it is an alarm, and withdraws no name.
inline constexpr double most_of_floor = 2.5;
// The disturbance grows with activity, speed or nearness to the ground.
// Statistic: rank correlation of energy; energy of the highest quarter over that of the lowest. From: no derivation. Costs: not measured.
inline constexpr double growth_correlation = 0.45, growth_ratio = 3.0;
// Of all structure, what the omnibus test may still find where everything is called explained.
// Statistic: its χ² as a share. From: no derivation. Costs: `partly_explained` instead of `explained`.
inline constexpr double explained_share = 0.1;

// ---- gusts

// A line of a gust. Statistic: probability by chance of the periodogram's peak. From: one false line in 10⁶ flights with none. Costs:
// fainter lines are not named.
inline constexpr double surely_a_line = 1e-6;
// A line is no gust's where the vehicle itself accelerates more there, or where most flights repeat a figure that has it as a harmonic.
// Statistic: amplitude over that of the acceleration; rms speed of an axis, share of its variance in one line, number of the harmonic. From: a gust
// moves a vehicle by no more than itself, 0.5 leaves room for resonance; figure eights of Neural-Fly, whose drag has a second harmonic. Costs: gusts at
// a harmonic of the flown figure.
inline constexpr double least_share_of_motion = 0.5, least_figure_mps = 0.1, least_share_of_line = 0.5,
                        most_harmonics = 6.0;
// A constant force beside a gust. Statistic: probability that it is more than the mean of the gust over a flight. From: one false
// force in a thousand flights. Costs: constant forces that a gust could be.
inline constexpr double surely_no_mean = 0.999;
// Dependence of a disturbance on the state. Statistic: standard deviations above the same series moved along its flight. From: no derivation.
// Costs: not measured.
inline constexpr double surely_dependent = 4.9;
// A gust lasts: correlation time, and disturbance that lasts half a second against all of a calm room's.
// Statistic: fitted correlation time, s; ratio of standard deviations. From: clean flights have up to 0.45 of the ratio; no derivation for the times.
// Costs: quicker and slower gusts are rough air or unnamed.
inline constexpr double fastest_gust_s = 0.25, slowest_gust_s = 4.0, least_slow_share = 0.7;
// It is more than rough air, which is about as strong up and down as sideways and forgets within a second.
// Statistic: horizontal over vertical standard deviation; correlation time, s. From: outdoor air of the independent reality 0.9 to 1.2 times and 0.3 to
// 0.7 s, its gusts 1.9 to 3.2 times. Costs: gusts that blow up and down as much.
inline constexpr double least_sideways = 1.4, longest_of_rough_air_s = 1.0;

// ---- hover without attitude and body rate

// Normal flights of one vehicle differ by so much, known as well as from so many flights.
// Statistic: share of weight (moments: of weight times lever). From: two vehicles, two flights each, CrazyPAD: 0.019, 0.006, 0.015, 0.014. Costs: (thresholds.md)
// 22 of 56 changed flights are not named exactly, none of 68 flights wrongly; at 0.013 14 and 3, at 0.03 35 and none. The second decides nothing from 2 to 8.
inline constexpr double flight_to_flight = 0.02, flight_to_flight_counts = 4.0;
// A flight differs from normal, and a change of the vehicle is adequate.
// Statistic: χ². From: one false change in a thousand flights. Costs: as above; at 0.05 16 and 2, at 1e-5 28 and none.
inline constexpr double hover_significance = 0.001;
// A change has one number more, or is another explanation that does as well.
// Statistic: squared standard deviations. From: p = 0.01; Akaike's two. Costs: the first none from 3.8 to 10.8; the second none at 1, 2 of 68 wrong at 4.
inline constexpr double number_costs = 6.6, other_number_costs = 2.0;
// It holds on held-out flights.
// Statistic: share of χ² that is left. From: no derivation. Costs: not measured.
inline constexpr double most_left_in_hover = 0.5;
// A rotor was asked for more than the battery gives.
// Statistic: share of hover at the fastest command. From: no derivation. Costs: the balance of yaw is left out; no name from 0.1 to 0.5.
inline constexpr double often_limited = 0.25;
// What a name by hover means is said to be worth, checked on held-out flights or not.
// Statistic: probability. From: no derivation. Costs: not calibrated; 34 of 34 names were right.
inline constexpr double checked_confidence = 0.95, unchecked_confidence = 0.85;

// ---- what is offered beside the names

// A flight distinguishes two names, or shows an effect of natural size.
// Statistic: expected Δχ². From: three and five standard deviations. Costs: advice, no name.
inline constexpr double distinguishes = 10.0, shows = 25.0;
// A term of the unnamed model must gain so much; the model is offered when it closes and loses so much.
// Statistic: Δχ² as a share of the samples, and of what all terms before it gained; share of the held-out error above noise, best and worst quantity. From:
// no derivation. Costs: no model is offered.
inline constexpr std::size_t most_terms = 6;
inline constexpr double term_materiality = 0.001, term_relative_materiality = 0.1, least_closed = 0.1, most_lost = 0.05;
// The habit of the recorded loop is offered when it predicts the body rate so much better than holding it.
// Statistic: ratio of errors half a second ahead. From: no derivation. Costs: no habit is offered.
inline constexpr double habit_better = 0.9;

}  // namespace gustlab::diagnosis::decisions
