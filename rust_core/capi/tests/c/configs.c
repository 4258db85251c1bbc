/* The report on a config. */
#include "check.h"

static const char CONFIG[] =
    "Visualization Manager:\n"
    "  Displays:\n"
    "  - {Class: rviz_camera_stream/CameraPub, Name: c, Enabled: true, Image Topic: /i, Camera Info Topic: /c}\n"
    "  - {Class: moveit_rviz_plugin/PlanningScene, Name: arm, Enabled: true, Planning Scene Topic: /scene}\n"
    "  - {Class: my/Own, Name: off, Enabled: false}\n"
    "  - {Class: rviz/Grid, Name: floor, Enabled: true, Colour: red}\n";

static void test_report(void)
{
  char report[1000], line[1000];
  RcsText report_text = { report, sizeof report, 0 }, line_text = { line, sizeof line, 0 };
  const size_t length = sizeof CONFIG - 1;
  /* Without a NUL, right before a protected page. */
  char *text = guarded(length);
  memcpy(text, CONFIG, length);
  CHECK(rcs_config_report(text, length, "/tmp/a b.rviz", &report_text, &line_text) == RCS_RESULT_OK);
  CHECK(report_text.needed == strlen(report) && line_text.needed == strlen(line));
  CHECK(strstr(report, "line 4: Displays / arm: unknown class moveit_rviz_plugin/PlanningScene, which needs a plugin of the "
                       "package moveit_ros_visualization (it shows /scene): "));
  CHECK(strstr(report, "\nline 6: Displays / floor / Colour: unknown key") && !strstr(report, "my/Own"));
  const char begin[] = "roslaunch rviz_camera_stream projection.launch 'rviz_config:=\"/tmp/a b.rviz\"' projector:=none ";
  CHECK(strncmp(line, begin, strlen(begin)) == 0);

  char *cut = guarded(20);
  RcsText cut_text = { cut, 20, 0 }, no_text = { NULL, 0, 0 };
  CHECK(rcs_config_report(text, length, "x", &cut_text, &no_text) == RCS_RESULT_OK);
  CHECK(cut_text.needed == strlen(report) && strncmp(cut, report, 19) == 0 && strlen(cut) == 19 && no_text.needed > 80);
  guarded_free(cut, 20);
  guarded_free(text, length);
}

static void test_refusals(void)
{
  char buffer[10] = "untouched";
  RcsText report = { buffer, sizeof buffer, 77 }, line = { buffer, sizeof buffer, 77 };
#define CALL(yaml, length, path) rcs_config_report(yaml, length, path, &report, &line)
  CHECK_FAILS(CALL(NULL, 0, "x"), RCS_RESULT_NULL_POINTER, "yaml is NULL");
  CHECK_FAILS(CALL(NULL, 5, "x"), RCS_RESULT_NULL_POINTER, "yaml is NULL");
  CHECK_FAILS(CALL("a", 1, NULL), RCS_RESULT_NULL_POINTER, "path is NULL");
  const size_t lengths[] = { SIZE_MAX, SIZE_MAX / 2 + 1, ((size_t)64 << 20) + 1 };
  for (size_t i = 0; i < 3; ++i)
    CHECK_FAILS(CALL("a", lengths[i], "x"), RCS_RESULT_BAD_LENGTH, "yaml_length is");
  CHECK_FAILS(CALL("", 0, "x.rviz"), RCS_RESULT_BAD_CONFIG, "x.rviz: no \"Visualization Manager\"");
  CHECK_FAILS(CALL("a: [", 4, "x.rviz"), RCS_RESULT_BAD_CONFIG, "x.rviz:");
  CHECK_FAILS(CALL("a\n\xff", 3, "x.rviz"), RCS_RESULT_BAD_CONFIG, "x.rviz: no \"Visualization Manager\"");
  CHECK_FAILS(CALL("\0", 1, "x.rviz"), RCS_RESULT_BAD_CONFIG, "x.rviz");
#undef CALL
  RcsText none = { NULL, 5, 77 };
  const size_t length = sizeof CONFIG - 1;
  CHECK_FAILS(rcs_config_report(CONFIG, length, "x", &none, &line), RCS_RESULT_NULL_POINTER, "report.buffer is NULL");
  CHECK_FAILS(rcs_config_report(CONFIG, length, "x", &line, &none), RCS_RESULT_NULL_POINTER, "launch_line.buffer is NULL");
  CHECK_FAILS(rcs_config_report(CONFIG, length, "x", NULL, &line), RCS_RESULT_NULL_POINTER, "report is NULL");
  CHECK_FAILS(rcs_config_report(CONFIG, length, "x", &line, NULL), RCS_RESULT_NULL_POINTER, "launch_line is NULL");
  CHECK(strcmp(buffer, "untouched") == 0 && report.needed == 77 && line.needed == 77 && none.needed == 77);
}

void test_configs(void)
{
  test_report();
  test_refusals();
}
