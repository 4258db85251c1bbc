/* What the node would draw of a config. */
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
  size_t report_needed = 0, line_needed = 0;
  uint32_t displays = 0;
  const size_t length = sizeof CONFIG - 1;
  /* Without a NUL, right before a page that nobody may read. */
  char *text = guarded(length);
  memcpy(text, CONFIG, length);
  CHECK(rcs_config_report(text, length, "/tmp/a b.rviz", report, sizeof report, &report_needed, line, sizeof line, &line_needed,
                          &displays) == RCS_RESULT_OK);
  CHECK(displays == 1 && report_needed == strlen(report) && line_needed == strlen(line));
  CHECK(strstr(report, "line 4: Displays / arm: unknown class moveit_rviz_plugin/PlanningScene, which needs a plugin of the "
                       "package moveit_ros_visualization (it shows /scene): "));
  CHECK(strstr(report, "\nline 6: Displays / floor / Colour: unknown key") && !strstr(report, "my/Own"));
  const char begin[] = "roslaunch rviz_camera_stream projection.launch 'rviz_config:=\"/tmp/a b.rviz\"' projector:=none ";
  CHECK(strncmp(line, begin, strlen(begin)) == 0);

  char *cut = guarded(20);
  CHECK(rcs_config_report(text, length, "x", cut, 20, &report_needed, NULL, 0, &line_needed, NULL) == RCS_RESULT_OK);
  CHECK(report_needed == strlen(report) && strncmp(cut, report, 19) == 0 && strlen(cut) == 19 && line_needed > 80);
  CHECK(rcs_config_report(text, length, "x", NULL, 0, NULL, NULL, 0, NULL, NULL) == RCS_RESULT_OK);
  guarded_free(cut, 20);
  guarded_free(text, length);
}

static void test_refusals(void)
{
  char buffer[10] = "untouched";
  size_t needed = 77;
  uint32_t displays = 77;
#define CALL(yaml, length, path, size) \
  rcs_config_report(yaml, length, path, buffer, size, &needed, buffer, size, &needed, &displays)
  CHECK_FAILS(CALL(NULL, 0, "x", 10), RCS_RESULT_NULL_POINTER, "yaml is NULL");
  CHECK_FAILS(CALL(NULL, 5, "x", 10), RCS_RESULT_NULL_POINTER, "yaml is NULL");
  CHECK_FAILS(CALL("a", 1, NULL, 10), RCS_RESULT_NULL_POINTER, "path is NULL");
  const size_t lengths[] = { SIZE_MAX, SIZE_MAX / 2 + 1, ((size_t)64 << 20) + 1 };
  for (size_t i = 0; i < 3; ++i)
    CHECK_FAILS(CALL("a", lengths[i], "x", 10), RCS_RESULT_BAD_LENGTH, "yaml_length is");
  CHECK_FAILS(CALL("", 0, "x.rviz", 10), RCS_RESULT_BAD_CONFIG, "x.rviz: no \"Visualization Manager\"");
  CHECK_FAILS(CALL("a: [", 4, "x.rviz", 10), RCS_RESULT_BAD_CONFIG, "x.rviz:");
  CHECK_FAILS(CALL("a\n\xff", 3, "x.rviz", 10), RCS_RESULT_BAD_CONFIG, "x.rviz:2: not UTF-8");
  CHECK_FAILS(CALL("\0", 1, "x.rviz", 10), RCS_RESULT_BAD_CONFIG, "x.rviz");
#undef CALL
  CHECK_FAILS(rcs_config_report(CONFIG, sizeof CONFIG - 1, "x", NULL, 5, &needed, NULL, 0, &needed, &displays),
              RCS_RESULT_NULL_POINTER, "report is NULL");
  CHECK_FAILS(rcs_config_report(CONFIG, sizeof CONFIG - 1, "x", NULL, 0, &needed, NULL, 5, &needed, &displays),
              RCS_RESULT_NULL_POINTER, "launch_line is NULL");
  CHECK(strcmp(buffer, "untouched") == 0 && needed == 77 && displays == 77);
}

void test_configs(void)
{
  test_report();
  test_refusals();
}
