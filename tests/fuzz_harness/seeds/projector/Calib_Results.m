% Focal length:
fc = [ 500.5 ; 501 ];
cc = [ 320 ; 240 ]';
alpha_c = 0.0;
kc = [ 1d-1 ; -.05 ; ... k1, k2
 .001 ; -.002 ; .01 ];
%{
kc = 2 * kc;
%}
calib_name = 'it''s 100%';
nx = 640; ny = 480;
